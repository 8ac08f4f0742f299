#include "pipeline/smooth/smooth_cloud.h"

#include "pipeline/build/each_chunk.h"
#include "pipeline/smooth/smooth_refit.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace slim {
namespace {

using nlohmann::json;

/// Points of a cloud that are smoothed together, and where they end.
class SmoothedBatch {
public:
    /// most: points that it is smoothed with; the last chunk may be above.
    explicit SmoothedBatch(std::size_t most) {
        from_.reserve(most + kChunkPoints), normals_.reserve(most + kChunkPoints);
    }
    std::size_t size() const { return from_.size(); }
    void add(const Smoother& smoother, const PointChunk& chunk) {
        for (const Vec3d& p : chunk.position) from_.push_back(p - smoother.origin);
        normals_.insert(normals_.end(), chunk.normal.begin(), chunk.normal.end());
    }
    void smooth(const SmoothSurface& surface, const Smoother& smoother) {
        points_.resize(from_.size());
        smooth_points(surface, smoother.settings(), from_, normals_, points_);
    }
    void write(const Smoother& smoother, SmoothCounts& counts, CloudRewriter& out) const {
        constexpr std::size_t kPiece = 4096;
        std::vector<RewrittenPoint> piece;
        for (std::size_t i = 0; i < from_.size();) {
            piece.clear();
            for (const std::size_t end = std::min(i + kPiece, from_.size()); i < end; ++i) {
                counts.add(from_[i], points_[i]);
                piece.push_back(smoother.rewritten(points_[i]));
            }
            out.write(piece);
        }
    }
    void clear() { from_.clear(), normals_.clear(), points_.clear(); }

private:
    std::vector<Vec3d> from_;     // frame of the job
    std::vector<Vec3f> normals_;  // of each, or none
    std::vector<SmoothedPoint> points_;
};

}  // namespace

json smooth_cloud(const Smoother& smoother) {
    const SmoothConfig& config = smoother.config;
    const SmoothRefit refit = refit_cloud({config.cloud, config.memory, smoother.tree,
                                           smoother.index, smoother.origin, smoother.diagonal},
                                          smoother.context);
    const SmoothSurface surface{smoother.index, refit.surface.get(), refit.trust};
    const auto out = rewrite_cloud(config.cloud, config.output, smoother.text_step(),
                                   smoother.noise_variance());
    SmoothCounts counts;
    SmoothedBatch done(refit.batch), next(refit.batch);
    // One thread alone counts and writes a batch: while the next one is smoothed.
    const auto take_turn = [&] {
        run_both([&] { done.write(smoother, counts, *out); },
                 [&] { next.smooth(surface, smoother); });
        std::swap(done, next);
        next.clear();
    };
    for_each_chunk({config.cloud}, smoother.context.reporter, "smooth",
                   [&](const PointChunk& chunk, std::uint64_t, std::size_t, const CloudInfo&) {
                       next.add(smoother, chunk);
                       if (next.size() >= refit.batch) take_turn();
                       smoother.context.check_stop();
                   });
    take_turn();
    done.write(smoother, counts, *out);
    require_moved(smoother, counts);
    out->commit();
    json result = counts.to_json("points");
    result["opposed"] = counts.opposed;
    result["astray"] = counts.astray;
    result["points_by_model"] = counts.by_model;
    result["points_held_back"] = counts.held_back;
    result.update(refit.counts());
    return result;
}

}  // namespace slim
