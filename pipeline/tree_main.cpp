#include "pipeline/build/slice_stage.h"
#include "pipeline/build/tree_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::TreeConfig>(
        {"tree",
         "stage 4: the fits of all slices to one model file",
         {"slim tree scan.work -o scan.slim"}},
        argc, argv, [](const slim::TreeConfig& config, slim::StageContext& context) {
            slim::check_slice_memory(config.memory);
            return slim::run_tree(config, context);
        });
}
