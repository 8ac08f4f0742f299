#include "pipeline/build_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::BuildConfig>(
        {"build",
         "a cloud to a model: slice, normals, fit and tree in one go",
         {"slim build scan.ply -o scan.slim", "slim build a.ply b.ply -o both.slim --t-mdl 0.003",
          "slim build terrain.xyz -o terrain.slim --degree 1 --memory 512MiB"}},
        argc, argv, slim::run_build);
}
