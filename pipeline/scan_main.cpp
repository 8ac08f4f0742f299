#include "pipeline/scan_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::ScanConfig>(
        {"scan",
         "virtual laser scanner over analytic shapes: a cloud with exact truth",
         {"slim scan sculpture -o cloud.ply --noise 0.0005",
          "slim scan sphere -o sphere.ply --points 100000 --pattern uniform"}},
        argc, argv, slim::run_scan);
}
