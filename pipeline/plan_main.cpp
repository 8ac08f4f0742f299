#include "pipeline/job/plan_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::PlanConfig>(
        {"plan",
         "Prints a job as a Makefile, a script for Slurm or a Snakefile, or explains it.",
         {"slim plan configs/demo.toml --format make > Makefile",
          "slim plan job.toml --format slurm --threads 8 > submit.sh && sh submit.sh "
          "--partition=short",
          "slim plan job.toml --format snakemake > Snakefile", "slim plan job.toml --explain"},
         true},
        argc, argv, slim::run_plan);
}
