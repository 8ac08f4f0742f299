#include "pipeline/build/slice_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::SliceConfig>(
        {"slice",
         "stage 1: one or many clouds into slices with one origin",
         {"slim slice scan.ply --work scan.work",
          "slim slice a.ply b.ply --work job.work --memory 512MiB"}},
        argc, argv, [](const slim::SliceConfig& config, slim::StageContext& context) {
            slim::check_slice_memory(config.memory);
            return slim::run_slice(config, context);
        });
}
