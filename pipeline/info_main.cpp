#include "pipeline/info_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::InfoConfig>(
        {"info",
         "What is in a file: counts, bounds, origin, attributes, provenance and health.",
         {"slim info scan.ply", "slim info scan.slim --json"},
         true},
        argc, argv, slim::run_info);
}
