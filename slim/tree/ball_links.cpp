#include "slim/tree/ball_links.h"

#include "slim/model/surfel.h"
#include "slim/model/surfel_tree.h"
#include "slim/neighbors/knn.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace slim {
namespace {

constexpr std::size_t kLinkedAtOnce = std::size_t{1} << 16;  // queries: 2 MiB

/// Over its radius, how far cores below a ball may reach: as far as that of a ball of the next
/// level whose centre it holds.
constexpr double kHeld = 1 + kGoldenRatio * kHitTrim;

bool holds(const LinkedBall& above, const LinkedBall& ball, double distance) {
    return distance + kHitTrim * ball.support_radius <= kHeld * above.support_radius;
}

/// Balls by level; indices are those of the input.
class Linker {
public:
    explicit Linker(std::span<const LinkedBall> balls) : balls_(balls) {
        links_.parent.assign(balls.size(), kNoNode);
    }

    /// From fine to coarse, so that one level is searched at a time: for those just below it, and
    /// for those that no finer ball holds.
    BallLinks link() {
        const std::vector<std::vector<std::uint32_t>> by_level = levels();
        std::vector<std::uint32_t> waiting;
        std::size_t n_orphans = 0;  // the first ones that wait
        for (std::size_t level = by_level.size(); level-- > 0;) {
            const std::vector<std::uint32_t>& here = by_level[level];
            std::vector<std::uint32_t> internal;
            std::copy_if(here.begin(), here.end(), std::back_inserter(internal),
                         [&](std::uint32_t i) { return !(balls_[i].flags & kLeaf); });
            if (!internal.empty() && !waiting.empty()) {
                waiting = link_level(internal, waiting, n_orphans);
                n_orphans = waiting.size();
            }
            waiting.insert(waiting.end(), here.begin(), here.end());
        }
        return std::move(links_);
    }

private:
    /// Indices of the balls of level 1, 2, ... in rising order.
    std::vector<std::vector<std::uint32_t>> levels() const {
        std::array<std::size_t, 256> n{};
        for (const LinkedBall& b : balls_) ++n[b.level];
        std::vector<std::vector<std::uint32_t>> out(255);
        for (std::size_t level = 1; level < n.size(); ++level) out[level - 1].reserve(n[level]);
        for (std::uint32_t i = 0; i < balls_.size(); ++i)
            if (balls_[i].level > 0) out[balls_[i].level - 1u].push_back(i);
        return out;
    }
    std::vector<Vec3d> centers_of(std::span<const std::uint32_t> some) const {
        std::vector<Vec3d> centers(some.size());
        std::transform(some.begin(), some.end(), centers.begin(),
                       [&](std::uint32_t i) { return balls_[i].center; });
        return centers;
    }
    /// Those that no ball of the level holds.
    std::vector<std::uint32_t> link_level(std::span<const std::uint32_t> above,
                                          std::span<const std::uint32_t> waiting,
                                          std::size_t n_orphans) {
        const KnnIndex index(centers_of(above));
        std::vector<std::uint32_t> left, found;
        std::vector<double> sq_distances;
        for (std::size_t i = 0; i < waiting.size(); i += kLinkedAtOnce) {
            const auto some = waiting.subspan(i, std::min(kLinkedAtOnce, waiting.size() - i));
            index.search(centers_of(some), 1, found, sq_distances);
            for (std::size_t k = 0; k < some.size(); ++k) {
                const std::uint32_t nearest = above[found[k]];
                if (holds(balls_[nearest], balls_[some[k]], std::sqrt(sq_distances[k]))) {
                    links_.parent[some[k]] = nearest;
                    continue;
                }
                left.push_back(some[k]);
                links_.n_orphans += i + k >= n_orphans;
            }
        }
        return left;
    }

    std::span<const LinkedBall> balls_;
    BallLinks links_;
};

}  // namespace

BallLinks link_balls(std::span<const LinkedBall> balls) { return Linker(balls).link(); }

}  // namespace slim
