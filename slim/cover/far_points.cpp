#include "slim/cover/far_points.h"

#include "slim/base/bbox.h"
#include "slim/base/parallel.h"
#include "slim/blend/blend.h"
#include "slim/cover/leaves_meeting.h"
#include "slim/cover/sound_normal.h"
#include "slim/fit/ball_points.h"
#include "slim/model/rim.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace slim {
namespace {

using Places = std::span<const std::uint32_t>;
using Leaves = std::vector<const Surfel*>;

constexpr std::size_t kLeavesTogether = 16;
constexpr std::size_t kTogether = 16;   // places that share a list of leaves
constexpr std::size_t kPieces = 64;     // of the places, for threads
constexpr std::size_t kLeastPiece = 128;  // each looks at all leaves once

constexpr double kNearEnough = 0.7;  // of what is far: first order is not exact
constexpr double kSurelyOut = 0.6;   // over rho, twice kBelongs: no root
                                     // is near enough to take part
constexpr double kGrazing = 0.2;     // cosine of a normal and a surface: first
                                     // order says nothing of where they meet
constexpr double kSurelyIn = 0.5;    // of its weight left by its rims
constexpr double kOutermost = 0.72;  // squared, over rho: beyond it G is less than
                                     // 1e-3 and moves no blend of a core's

/// What a smooth leaf is to a point in its ball.
enum class Part { none, near, doubtful };

Part part_of(const Surfel& s, const Vec3d& x, const Vec3d& normal, double farthest) {
    const Vec3d local = s.frame.local_from_world(x), n = s.frame.local_from_world(normal);
    const double slope_u = s.polynomial.d_u(local.x, local.y),
                 slope_v = s.polynomial.d_v(local.x, local.y);
    const double along = n.z - n.x * slope_u - n.y * slope_v;  // n . grad f
    const double grazing = kGrazing * std::sqrt(1 + slope_u * slope_u + slope_v * slope_v);
    if (along < -grazing) return Part::none;
    if (along < grazing) return Part::doubtful;
    const double off = std::abs(local.z - s.polynomial.value(local.x, local.y)) / along;
    if (off > kSurelyOut) return Part::none;
    if (off * s.support_radius > kNearEnough * farthest) return Part::doubtful;
    return rim_share(s.rims, local.x, local.y) > kSurelyIn ? Part::near : Part::none;
}

/// What is known of each place. Written by several threads, all of them true.
struct Marks {
    std::vector<std::uint8_t> met, doubtful;

    explicit Marks(std::size_t n) : met(n), doubtful(n) {}
    static void set(std::uint8_t& mark) {
        std::atomic_ref(mark).store(1, std::memory_order_relaxed);
    }
    /// Marks the points of a leaf's ball.
    void add(const PointTree& points, const Surfel& s, double farthest, BallPoints<double>& ball) {
        gather_ball(points, s.center, s.support_radius, ball);
        for (std::size_t i = 0; i < ball.n; ++i) {
            const Vec3d x{ball.x[i], ball.y[i], ball.z[i]}, n{ball.nx[i], ball.ny[i], ball.nz[i]};
            const Part part = s.sharp ? Part::doubtful : part_of(s, x, n, farthest);
            if (part == Part::near && ball.sq[i] < kTrim * kTrim) set(met[ball.index[i]]);
            if (part == Part::doubtful && (s.sharp || ball.sq[i] < kOutermost))
                set(doubtful[ball.index[i]]);
        }
    }
};

/// Looks at places that lie together: at those of either half with the leaves that may hold them.
class FarSearch {
public:
    FarSearch(const PointTree& points, double farthest, bool sound)
        : points_(points), farthest_(farthest), sound_(sound) {}

    void look(Places places, const Leaves& leaves, std::vector<FarPoint>& out) const {
        Bbox box;
        for (const std::uint32_t place : places) box.extend(points_.position(place));
        const Leaves near = leaves_meeting(box, leaves);
        if (places.size() > kTogether) {
            const std::size_t half = places.size() / 2;
            look(places.first(half), near, out);
            look(places.subspan(half), near, out);
            return;
        }
        for (const std::uint32_t place : places) look_at(place, near, out);
    }

private:
    void look_at(std::uint32_t place, const Leaves& leaves, std::vector<FarPoint>& out) const {
        const Vec3d n =
            sound_ ? sound_normal(points_, place) : to_double(points_.normal(place));
        if (!(sq_length(n) > 0)) return;
        const Vec3d p = points_.position(place);
        const Leaves supporters = leaves_meeting({p, p}, leaves);
        const auto at = project_along(p, normalized(n), supporters);
        const double off = at ? std::abs(at->t) : INFINITY;
        if (off > farthest_) out.push_back({place, off});
    }

    const PointTree& points_;
    double farthest_;
    bool sound_;
};

}  // namespace

std::vector<std::uint32_t> maybe_far(const PointTree& points, const Leaves& leaves,
                                     double farthest) {
    Marks marks(points.size());
    tbb::enumerable_thread_specific<BallPoints<double>> balls;
    parallel_blocks(leaves.size(), kLeavesTogether, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            marks.add(points, *leaves[i], farthest, balls.local());
    });
    std::vector<std::uint32_t> out;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (marks.doubtful[i] || !marks.met[i]) out.push_back(static_cast<std::uint32_t>(i));
    return out;
}

std::vector<FarPoint> far_points(const PointTree& points, Places places, const Leaves& leaves,
                                 double farthest, bool sound) {
    const FarSearch search(points, farthest, sound);
    const std::size_t piece = std::max(kLeastPiece, (places.size() + kPieces - 1) / kPieces);
    std::vector<std::vector<FarPoint>> found((places.size() + piece - 1) / piece);
    parallel_blocks(places.size(), piece, [&](std::size_t begin, std::size_t end) {
        search.look(places.subspan(begin, end - begin), leaves, found[begin / piece]);
    });
    std::vector<FarPoint> out;
    for (const auto& f : found) out.insert(out.end(), f.begin(), f.end());
    return out;
}

}  // namespace slim
