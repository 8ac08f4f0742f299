#include "pipeline/render/render_stage.h"

int main(int argc, char** argv) {
    return slim::run_stage<slim::RenderConfig>(
        {"render",
         "pictures of a model: shaded, curvature maps, feature lines, data channels",
         {"slim render bunny.slim -o bunny.png",
          "slim render bunny.slim -o pictures/ --aov shaded,mean,k1 --camera iso --supersample 2",
          "slim render bunny.slim -o bunny.exr --aov all",
          "slim render bunny.slim -o bunny.png --mode raytrace --ground --ao",
          "slim render terrain.slim -o evening.png --mode raytrace --up z --camera top --light "
          "'sun azimuth=315 elevation=12'",
          "slim render bunny3.slim -o drawing.png --aov lines --lines contour,suggestive,crest",
          "slim render bunny.slim -o pictures/ --job job.toml --size 3200x2400",
          "slim render part.slim -o part.png --aov lines --lines contour,crease --lines-obj "
          "edges.obj"}},
        argc, argv, slim::run_render);
}
