#include "pipeline/measure/measure_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::MeasureConfig>(
        {"measure",
         "Distance, normals and curvature of a cloud against a model; l2 and max are the RMS and "
         "the largest distance of the points, along their normals, to the leaves as they blend "
         "(build's fit error is of each leaf alone), as shares of the model's diagonal L; "
         "normal_rms_deg is in degrees, curvatures in 1 / unit. Of a mesh the points are its "
         "vertices; faces has the same of 200,000 samples of its faces' area, and completeness is "
         "the share of that area. Of two pictures: how they differ. "
         "Of a mesh and the same with its vertices moved: how far each went, and how the faces' "
         "normals turned. Of two clouds of as many points: how far each went (l2: the RMS "
         "displacement); with --two-way, of any two (of a mesh and a cloud the mesh's vertices "
         "count): to the nearest points.",
         {"slim measure scan.slim scan.ply --two-way --per-point distances.ply",
          "slim measure torus.slim torus.ply --truth torus.truth --json",
          "slim measure shape:torus smoothed.ply",
          "slim measure shape:torus far.ply --offset 500000,4e6,100",
          "slim measure before.png after.png -o difference.png",
          "slim measure original.ply smoothed.ply --per-point moved.ply",
          "slim measure scan.ply other_scan.ply --two-way"},
         true,
         {{"l2", "of L"},
          {"max", "of L"},
          {"p50", "of L"},
          {"p90", "of L"},
          {"p95", "of L"},
          {"p99", "of L"},
          {"missed", "points"},
          {"completeness", "of the points (a mesh: of its faces' area)"},
          {"points", ""},
          {"opposed", "points"},
          {"astray", "points"},
          {"normal_rms_deg", "degrees"},
          {"normal_mean_deg", "degrees"},
          {"normal_p99_deg", "degrees"},
          {"diagonal", "(L)"}}},
        argc, argv, slim::run_measure);
}
