#include "pipeline/measure_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::MeasureConfig>(
        {"measure",
         "distance, normals and curvature of a cloud against a model; l2 and max are the RMS and "
         "the largest distance of the points, along their normals, to the leaves as they blend "
         "(build's fit error is of each leaf alone), as shares of the model's diagonal L; "
         "normal_rms_deg is in degrees, curvatures in 1 / unit",
         {"slim measure scan.slim scan.ply",
          "slim measure torus.slim torus.ply --truth torus.truth --json"},
         true},
        argc, argv, slim::run_measure);
}
