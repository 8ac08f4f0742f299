#include "pipeline/report/report_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::ReportConfig>(
        {"report",
         "Experiments as curves of error against run time: runs the steps that report files ask "
         "for, each once, and writes one page with tables, plots and pictures, CSV and JSON. Ends "
         "with 5, naming them, if figures leave their bands. What is done is not run again.",
         {"slim report configs/report/quick.toml -o out/quick",
          "slim report configs/report/scale.toml -o out/scale --set values.largest=1e8",
          "slim report coarse.toml fine.toml -o out/jobs",
          "slim report configs/report/*.toml -o out/report --programs build-peers"},
         true},
        argc, argv, slim::run_report);
}
