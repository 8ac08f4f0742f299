#include "pipeline/build/slice_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::SliceConfig>(
        {"slice",
         "stage 1: one or many clouds into slices with one origin",
         {"slim slice scan.ply --work scan.work",
          "slim slice a.ply b.ply --work job.work --memory 512MiB"}},
        argc, argv, slim::run_slice);
}
