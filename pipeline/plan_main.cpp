#include "pipeline/plan_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::PlanConfig>(
        {"plan",
         "Prints a job as a Makefile whose targets are its outputs, or explains it.",
         {"slim plan configs/demo.toml --format make > Makefile", "slim plan job.toml --explain"},
         true},
        argc, argv, slim::run_plan);
}
