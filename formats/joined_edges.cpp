#include "formats/joined_edges.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <optional>

namespace slim {
namespace {

constexpr double kStraight = 0.15;   // of the size: farthest of a chain's points from its chord
constexpr double kAlike = 1.2;       // largest over least size of a chain
constexpr std::size_t kLongest = 256;  // edges of a chain

/// Edges by their ends.
class Chains {
public:
    explicit Chains(std::span<const SizedEdge> edges) : edges_(edges), taken_(edges.size(), false) {
        for (std::size_t i = 0; i < edges.size(); ++i)
            for (const Vec3d& end : {edges[i].from, edges[i].to}) at_[key(end)].push_back(i);
    }
    bool is_taken(std::size_t i) const { return taken_[i]; }

    /// The edge that begins with i and goes on from its end as long as it is straight.
    SizedEdge take_chain(std::size_t i) {
        taken_[i] = true;
        SizedEdge out = edges_[i];
        double largest = out.size;
        std::vector<Vec3d> passed;
        while (passed.size() < kLongest) {
            const auto next = next_of(out.to);
            if (!next) break;
            const SizedEdge& e = edges_[*next];
            const Vec3d end = e.from == out.to ? e.to : e.from;
            const double least = std::min(out.size, e.size);
            largest = std::max(largest, e.size);
            passed.push_back(out.to);
            const SizedEdge chord{out.from, end, least};
            const auto is_off = [&](const Vec3d& p) {
                return !(chord.distance(p) <= kStraight * least);
            };
            if (largest > kAlike * least || std::any_of(passed.begin(), passed.end(), is_off))
                break;
            taken_[*next] = true;
            out = chord;
        }
        return out;
    }

private:
    using Key = std::array<double, 3>;
    static Key key(const Vec3d& p) { return {p.x, p.y, p.z}; }

    /// The one edge that goes on at a point where no more than two meet.
    std::optional<std::size_t> next_of(const Vec3d& end) const {
        const auto meeting = at_.find(key(end));
        if (meeting == at_.end() || meeting->second.size() != 2) return std::nullopt;
        for (const std::size_t i : meeting->second)
            if (!taken_[i]) return i;
        return std::nullopt;
    }

    std::span<const SizedEdge> edges_;
    std::vector<bool> taken_;
    std::map<Key, std::vector<std::size_t>> at_;
};

}  // namespace

std::vector<SizedEdge> joined_edges(std::span<const SizedEdge> edges) {
    Chains chains(edges);
    std::vector<SizedEdge> out;
    for (std::size_t i = 0; i < edges.size(); ++i)
        if (!chains.is_taken(i)) out.push_back(chains.take_chain(i));
    return out;
}

}  // namespace slim
