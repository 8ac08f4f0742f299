#include "pipeline/smooth/smooth_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::SmoothConfig>(
        {"smooth",
         "moves the points of a cloud, or the vertices of a mesh, onto a model's surface; "
         "attributes, order and faces are kept, displacements are in the cloud's unit; noise is "
         "the standard deviation of a point about its neighbours, along the normal, over the "
         "diagonal L (median leaf)",
         {"slim smooth scan.slim scan.ply -o smooth.ply",
          "slim smooth mesh.slim mesh.ply -o smooth.ply --most 0.5",
          "slim smooth mesh.slim mesh.ply -o smooth.ply --mode points --json"},
         false,
         {{"rms_displacement", ""},
          {"max_displacement", ""},
          {"moved", "points"},
          {"unsupported", "points, which stay"},
          {"points", ""},
          {"noise", "of L, in the median leaf"}}},
        argc, argv, slim::run_smooth);
}
