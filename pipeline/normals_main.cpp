#include "pipeline/build/normals_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::NormalsConfig>(
        {"normals",
         "stage 2: oriented normals for every point, and the noise of the cloud",
         {"slim normals scan.work", "slim normals scan.work --slice 3 --normals estimate"}},
        argc, argv, slim::run_normals);
}
