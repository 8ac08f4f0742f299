#include "pipeline/job/run_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::RunConfig>(
        {"run",
         "All that a job file asks for: scan or read, build, measure, draw, and a page with the "
         "results.",
         {"slim run plate scan.ply", "slim run configs/demo.toml",
          "slim plan configs/demo.toml --explain"},
         true},
        argc, argv, slim::run_job, slim::resolved_run);
}
