#include "slim/fit/points_on_faces.h"

#include "slim/base/bbox.h"
#include "slim/base/parallel.h"
#include "slim/neighbors/box_tree.h"
#include "slim/neighbors/point_tree.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace slim {
namespace {

constexpr double kEverywhere = 0.25;  // typical variance over lambda, at least
constexpr double kShows = 0.05;       // typical noise over the spacing, at least
constexpr double kLeft = 0.4;         // of the typical variance; neighbours err alike
constexpr double kReach = 3.5;        // spacings: some 38 points, of which 10 count as one would
constexpr double kUsualTurns = 1.5;   // times the usual difference of two normals: alike, ...
constexpr double kLeastTurn = 0.01, kMostTurn = 0.7;  // from half a degree to 41, as edges are
constexpr int kTurns = 8, kMoves = 3;
constexpr std::size_t kGrain = 16;  // buckets
constexpr std::size_t kMostNear = 512;  // points about a bucket: of more, where points lie densely,
                                        // every so manieth

/// A point as it is after some passes.
struct Oriented {
    Vec3d position, normal;
    bool has_normal() const { return sq_length(normal) > 0; }
};

constexpr double square(double x) { return x * x; }

/// How much a point on the same face counts: nothing beyond the reach, or where normals differ by
/// `turn`.
struct Likeness {
    double sq_reach, sq_turn;

    double operator()(const Oriented& a, const Oriented& b) const {
        const double sq = sq_length(a.position - b.position);
        if (sq >= sq_reach) return 0;  // most are
        const double alike = 1 - sq_length(a.normal - b.normal) / sq_turn;
        return alike > 0 && b.has_normal() ? square((1 - sq / sq_reach) * square(alike)) : 0;
    }
};

/// Half of the differences of normals between neighbours on the Morton curve are less.
double usual_turn(std::span<const Oriented> points) {
    std::vector<double> squares;
    for (std::size_t i = 1; i < points.size(); ++i)
        if (points[i].has_normal() && points[i - 1].has_normal())
            squares.push_back(sq_length(points[i].normal - points[i - 1].normal));
    if (squares.empty()) return 0;
    const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
    std::nth_element(squares.begin(), middle, squares.end());
    return std::sqrt(*middle);
}

/// What points near a point make of it.
using Agreement = Oriented (*)(const Oriented& point, std::span<const Oriented> near,
                               const Likeness& weight);

Oriented turned(const Oriented& p, std::span<const Oriented> near, const Likeness& weight) {
    Vec3d sum;
    for (const Oriented& q : near)
        if (const double w = weight(p, q); w > 0) sum += q.normal * w;
    return {p.position, normalized(sum)};
}

Oriented moved(const Oriented& p, std::span<const Oriented> near, const Likeness& weight) {
    Vec3d sum;
    double total = 0;
    for (const Oriented& q : near) {
        const double w = weight(p, q);
        if (!(w > 0)) continue;
        const Vec3d across = normalized(p.normal + q.normal);
        sum += across * (w * dot(across, q.position - p.position));
        total += w;
    }
    return {p.position + sum / total, p.normal};
}

/// Points in Morton order; the boxes are those of their first places, as they move by less than the
/// reach.
class Passes {
public:
    Passes(std::vector<Oriented> points, double reach)
        : now_(std::move(points)),
          next_(now_),
          boxes_(now_.size(), [this](std::size_t i) { return now_[i].position; }),
          reach_(reach),
          weight_{square(reach),
                  square(std::clamp(kUsualTurns * usual_turn(now_), kLeastTurn, kMostTurn))} {}

    void run(int n, Agreement agree) {
        for (int i = 0; i < n; ++i) {
            parallel_blocks(boxes_.n_buckets(), kGrain, [&](std::size_t begin, std::size_t end) {
                std::vector<Oriented> near;
                for (std::size_t b = begin; b < end; ++b) run_bucket(b, agree, near);
            });
            now_.swap(next_);
        }
    }
    const std::vector<Oriented>& points() const { return now_; }

private:
    void run_bucket(std::size_t bucket, Agreement agree, std::vector<Oriented>& near) {
        const std::size_t begin = bucket * BoxTree::kBucket;
        const std::size_t end = std::min(begin + BoxTree::kBucket, now_.size());
        std::size_t n = 0;
        const auto for_near = [&](const auto& visit) {
            boxes_.for_buckets_near(boxes_.bucket(bucket), reach_, visit);
        };
        for_near([&](std::size_t first, std::size_t last) { n += last - first; });
        const std::size_t stride = n / kMostNear + 1;
        near.assign(now_.begin() + static_cast<std::ptrdiff_t>(begin),
                    now_.begin() + static_cast<std::ptrdiff_t>(end));  // its own in any case
        std::size_t k = 0;
        for_near([&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i)
                if (k++ % stride == 0 && (i < begin || i >= end)) near.push_back(now_[i]);
        });
        for (std::size_t i = begin; i < end; ++i)
            next_[i] = now_[i].has_normal() ? agree(now_[i], near, weight_) : now_[i];
    }

    std::vector<Oriented> now_, next_;
    BoxTree boxes_;
    double reach_;
    Likeness weight_;
};

}  // namespace

bool PartNoise::is_everywhere() const {
    return spacing > 0 && typical_variance > kEverywhere * variance &&
           typical_variance > square(kShows * spacing);
}

double PartNoise::reach() const { return kReach * spacing; }

PartNoise PartNoise::left() const {
    const double typical = std::min(typical_variance, variance);
    return {variance - (1 - kLeft) * typical, kLeft * typical, spacing};
}

PointBlock points_on_faces(const PointBlock& points, double reach) {
    PointBlock out = points;
    if (points.empty() || !points.has_normals() || !(reach > 0)) return out;
    Bbox box;
    for (const Vec3d& p : points.position) box.extend(p);
    const std::vector<std::uint32_t> order = morton_order(points, box);
    std::vector<Oriented> oriented(points.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        oriented[i] = {points.position[order[i]], to_double(points.normal[order[i]])};
    Passes passes(std::move(oriented), reach);
    passes.run(kTurns, turned);
    passes.run(kMoves, moved);
    for (std::size_t i = 0; i < order.size(); ++i) {
        out.position[order[i]] = passes.points()[i].position;
        out.normal[order[i]] = to_float(passes.points()[i].normal);
    }
    return out;
}

}  // namespace slim
