#include "pipeline/info/info_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::InfoConfig>(
        {"info",
         "What is in a file: counts, bounds, origin, attributes, provenance and health. noise is "
         "the standard deviation of a point, over the diagonal L, as of slim scan, build and "
         "smooth; edges and bends count in it, in noise_typical hardly; --json has all counts and "
         "rules of the fits.",
         {"slim info scan.ply", "slim info scan.slim --json"},
         true},
        argc, argv, slim::run_info);
}
