#include "slim/cover/far_points.h"

#include "slim/base/bbox.h"
#include "slim/base/parallel.h"
#include "slim/base/simd.h"
#include "slim/blend/blend.h"
#include "slim/cover/leaf_balls.h"
#include "slim/cover/leaves_along_curve.h"
#include "slim/cover/sound_normal.h"
#include "slim/fit/ball_points.h"
#include "slim/model/rim.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>

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

using Lanes = stdx::native_simd<double>;

/// What a smooth leaf is to the points of its ball, by bits of a group's lanes: surely near to its
/// surface, or not to be told to first order.
struct Parts {
    std::uint64_t near, doubtful;
};

class PartsOfBall {
public:
    PartsOfBall(const Surfel& s, const BallPoints<double>& ball, double farthest)
        : ball_(ball),
          rims_{unpack_rim(s.rims.first), unpack_rim(s.rims.second)},
          has_rims_(s.rims.any()),
          near_enough_(kNearEnough * farthest / s.support_radius) {
        const auto spread = [](const Vec3d& v) {
            return Vec3<Lanes>{Lanes(v.x), Lanes(v.y), Lanes(v.z)};
        };
        frame_ = {spread(s.frame.u_axis), spread(s.frame.v_axis), spread(s.frame.normal)};
        for (std::size_t k = 0; k < polynomial_.a.size(); ++k)
            polynomial_.a[k] = s.polynomial.a[k];
    }
    /// Of the points from `first` on.
    Parts of_group(std::size_t first) const {
        const auto at = [&](const std::vector<double>& a) {
            return Lanes(&a[first], stdx::element_aligned);
        };
        const auto along_axis = [&](const std::vector<float>& a) {
            return stdx::static_simd_cast<Lanes>(
                LanesOfDouble<float>(&a[first], stdx::element_aligned));
        };
        const Lanes sq = at(ball_.sq);
        const Vec3<Lanes> x = frame_.local_from_world({at(ball_.x), at(ball_.y), at(ball_.z)});
        const Vec3<Lanes> n = frame_.local_from_world(
            {along_axis(ball_.nx), along_axis(ball_.ny), along_axis(ball_.nz)});
        const Lanes slope_u = polynomial_.d_u(x.x, x.y), slope_v = polynomial_.d_v(x.x, x.y);
        const Lanes along = n.z - n.x * slope_u - n.y * slope_v;  // n . grad f
        const Lanes grazing = kGrazing * stdx::sqrt(1 + slope_u * slope_u + slope_v * slope_v);
        const Lanes off = stdx::abs(x.z - polynomial_.value(x.x, x.y)) / along;
        const std::uint64_t in_core = lane_bits(sq < kTrim * kTrim);
        const std::uint64_t inside = lane_bits(sq < kOutermost);  // not the padding
        const std::uint64_t away = lane_bits(along < -grazing), steep = lane_bits(along < grazing);
        const std::uint64_t out = lane_bits(off > kSurelyOut),
                            far = lane_bits(off > near_enough_);
        return {within_rims(in_core & ~(steep | out | far), x),
                inside & ~away & (steep | (~out & far))};
    }

private:
    std::uint64_t within_rims(std::uint64_t near, const Vec3<Lanes>& x) const {
        if (!has_rims_) return near;
        for (const Rim& rim : rims_) {
            const Lanes share = (rim.reach - (rim.u * x.x + rim.v * x.y)) / kRimRamp;
            near &= lane_bits(share > kSurelyIn);
        }
        return near;
    }
    const BallPoints<double>& ball_;
    std::array<Rim, 2> rims_;
    bool has_rims_;
    double near_enough_;  // over rho
    Frame<Lanes> frame_;
    Polynomial<Lanes> polynomial_;
};

/// What is known of each place. Written by several threads, all of them true.
struct Marks {
    std::vector<std::uint8_t> met, doubtful;

    explicit Marks(std::size_t n) : met(n), doubtful(n) {}
    static void set(std::uint8_t& mark) {
        std::atomic_ref(mark).store(1, std::memory_order_relaxed);
    }
    /// Marks the points of a leaf's ball.
    [[gnu::flatten]] void add(const PointTree& points, const Surfel& s, double farthest,
                              BallPoints<double>& ball) {
        gather_ball(points, s.center, s.support_radius, ball);
        if (s.sharp) {
            for (std::size_t i = 0; i < ball.n; ++i) set(doubtful[ball.index[i]]);
            return;
        }
        const PartsOfBall parts(s, ball, farthest);
        for (std::size_t first = 0; first < ball.n; first += Lanes::size()) {
            const Parts part = parts.of_group(first);
            const auto set_all = [&](std::uint64_t bits, std::vector<std::uint8_t>& marks) {
                for (; bits != 0; bits &= bits - 1) {
                    const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
                    set(marks[ball.index[first + lane]]);
                }
            };
            set_all(part.near, met), set_all(part.doubtful, doubtful);
        }
    }
};

/// Looks at places that lie together: at those of either half with the leaves that may hold them.
class FarSearch {
public:
    FarSearch(const PointTree& points, double farthest, bool sound)
        : points_(points), farthest_(farthest), sound_(sound) {}

    void look(Places places, const LeafBalls& leaves, std::vector<FarPoint>& out) const {
        Bbox box;
        for (const std::uint32_t place : places) box.extend(points_.position(place));
        const LeafBalls near = leaves.meeting(box);
        if (places.size() > kTogether) {
            const std::size_t half = places.size() / 2;
            look(places.first(half), near, out);
            look(places.subspan(half), near, out);
            return;
        }
        for (const std::uint32_t place : places) look_at(place, near, out);
    }

private:
    void look_at(std::uint32_t place, const LeafBalls& leaves, std::vector<FarPoint>& out) const {
        const Vec3d n =
            sound_ ? sound_normal(points_, place) : to_double(points_.normal(place));
        if (!(sq_length(n) > 0)) return;
        const Vec3d p = points_.position(place);
        const LeafBalls about = leaves.meeting({p, p});
        Leaves supporters(about.size());
        for (std::size_t i = 0; i < about.size(); ++i) supporters[i] = about[i];
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
    const Leaves ordered =
        leaves_along_curve(leaves, [](const Surfel& s) -> const Surfel& { return s; });
    parallel_blocks(ordered.size(), kLeavesTogether, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            marks.add(points, *ordered[i], farthest, balls.local());
    });
    std::vector<std::uint32_t> out;
    for (std::size_t i = 0; i < points.size(); ++i)
        if (marks.doubtful[i] || !marks.met[i]) out.push_back(static_cast<std::uint32_t>(i));
    return out;
}

std::vector<FarPoint> far_points(const PointTree& points, Places places, const Leaves& leaves,
                                 double farthest, bool sound) {
    const FarSearch search(points, farthest, sound);
    const LeafBalls balls(leaves);
    const std::size_t piece = std::max(kLeastPiece, (places.size() + kPieces - 1) / kPieces);
    std::vector<std::vector<FarPoint>> found((places.size() + piece - 1) / piece);
    parallel_blocks(places.size(), piece, [&](std::size_t begin, std::size_t end) {
        search.look(places.subspan(begin, end - begin), balls, found[begin / piece]);
    });
    std::vector<FarPoint> out;
    for (const auto& f : found) out.insert(out.end(), f.begin(), f.end());
    return out;
}

}  // namespace slim
