#include "pipeline/build/build_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::BuildConfig>(
        {"build",
         "a cloud to a model: slice, normals, fit and tree in one go; its fit error "
         "(leaf_error_rms) is the RMS residual of each leaf's own fit over the diagonal, l2 of "
         "`slim measure` the distance of the points to the leaves as they blend; noise is the "
         "standard deviation of a point, over the diagonal L",
         {"slim build scan.ply -o scan.slim", "slim build a.ply b.ply -o both.slim --t-mdl 0.003",
          "slim build terrain.xyz -o terrain.slim --degree 1 --memory 512MiB"}},
        argc, argv, slim::run_build);
}
