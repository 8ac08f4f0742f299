#include "pipeline/build/fit_stage.h"
#include "pipeline/build/slice_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::FitConfig>(
        {"fit",
         "stage 3: multi-scale surfels for each slice",
         {"slim fit scan.work --degree 2 --t-mdl 0.01", "slim fit scan.work --slice 3"}},
        argc, argv, [](const slim::FitConfig& config, slim::StageContext& context) {
            slim::check_slice_memory(config.memory);
            return slim::run_fit(config, context);
        });
}
