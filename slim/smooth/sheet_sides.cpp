#include "slim/smooth/sheet_sides.h"

#include "slim/base/parallel.h"
#include "slim/blend/sheet_normals.h"
#include "slim/smooth/point_projector.h"

#include <atomic>
#include <vector>

namespace slim {
namespace {

constexpr std::size_t kGrain = 2048;

bool has_sheets_apart(const BallIndex& model) {
    std::atomic<bool> any = false;
    parallel_blocks(model.n_leaves(), 64, [&](std::size_t begin, std::size_t end) {
        std::vector<const Surfel*> found;
        for (std::size_t i = begin; i < end && !any; ++i) {
            const Surfel& leaf = model.leaf(i);
            model.supporters(leaf.center, found);
            for (const Surfel* s : found)
                if (dot(s->frame.normal, leaf.frame.normal) < 0) any = true;
        }
    });
    return any;
}

}  // namespace

void tell_sheets_apart(const BallIndex& model, PointBlock& points) {
    if (!has_sheets_apart(model)) return;
    if (!points.has_normals()) points.normal.assign(points.size(), Vec3f{});
    parallel_blocks(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        PointProjector projector(model);
        for (std::size_t i = begin; i < end; ++i) {
            if (sq_length(points.normal[i]) > 0) continue;
            const ProjectedPoint put = projector.project(points.position[i], {});
            if (!put.hit || put.astray) continue;
            const auto sheets = sheet_normals_at(points.position[i], projector.supporters());
            if (sheets && sq_length(sheets->second) > 0) points.normal[i] = to_float(put.direction);
        }
    });
}

}  // namespace slim
