#include "slim/normals/sign_merge.h"

#include <algorithm>
#include <cmath>
#include <memory_resource>
#include <queue>
#include <unordered_map>
#include <utility>

namespace slim {
namespace {

/// The votes between groups that still stand for themselves.
class VoteGraph {
public:
    VoteGraph(std::uint32_t n, const std::vector<SignVote>& votes)
        : neighbors_(n), alive_(n, true), weight_(&memory_) {
        weight_.reserve(votes.size());
        for (const SignVote& v : votes) add(v.a, v.b, v.weight);
        std::vector<Sure> all;
        all.reserve(weight_.size());
        for (const auto& [pair, weight] : weight_)
            all.push_back({std::abs(weight), static_cast<std::uint32_t>(pair >> 32),
                           static_cast<std::uint32_t>(pair)});
        queue_ = std::priority_queue<Sure>({}, std::move(all));
    }

    /// Takes the surest pair, joins it in `forest` and adds up their votes; false: there is none.
    bool merge_surest(SignedForest& forest) {
        while (!queue_.empty()) {
            const Sure sure = queue_.top();
            queue_.pop();
            const auto vote = weight_.find(key(sure.a, sure.b));
            if (vote == weight_.end() || std::abs(vote->second) != sure.weight) continue;
            const bool opposed = vote->second < 0;
            weight_.erase(vote);
            forest.join(sure.a, sure.b, opposed);
            if (neighbors_[sure.a].size() < neighbors_[sure.b].size())
                move_votes(sure.a, sure.b, opposed);
            else move_votes(sure.b, sure.a, opposed);
            return true;
        }
        return false;
    }

private:
    struct Sure {
        double weight;
        std::uint32_t a, b;
        bool operator<(const Sure& o) const {
            return weight != o.weight ? weight < o.weight : a != o.a ? a > o.a : b > o.b;
        }
    };

    static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
        return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
    }
    void add(std::uint32_t a, std::uint32_t b, double weight) {
        const auto [at, is_new] = weight_.try_emplace(key(a, b), weight);
        if (!is_new) {
            at->second += weight;
            return;
        }
        neighbors_[a].push_back(b);
        neighbors_[b].push_back(a);
    }
    void push(std::uint32_t a, std::uint32_t b) {
        const double weight = weight_.at(key(a, b));
        queue_.push({std::abs(weight), std::min(a, b), std::max(a, b)});
    }
    /// What `from` says of others is said by `to`.
    void move_votes(std::uint32_t from, std::uint32_t to, bool opposed) {
        alive_[from] = false;
        for (const std::uint32_t other : neighbors_[from]) {
            if (!alive_[other] || other == to) continue;
            const auto vote = weight_.find(key(from, other));
            if (vote == weight_.end()) continue;
            const double weight = opposed ? -vote->second : vote->second;
            weight_.erase(vote);
            add(to, other, weight);
            push(to, other);
        }
        neighbors_[from] = {};
    }

    std::vector<std::vector<std::uint32_t>> neighbors_;  ///< some no longer alive
    std::vector<bool> alive_;
    std::pmr::unsynchronized_pool_resource memory_;
    std::pmr::unordered_map<std::uint64_t, double> weight_;
    std::priority_queue<Sure> queue_;
};

}  // namespace

SignedForest merge_by_votes(std::uint32_t n, const std::vector<SignVote>& votes) {
    SignedForest forest(n);
    VoteGraph graph(n, votes);
    while (graph.merge_surest(forest)) {}
    return forest;
}

}  // namespace slim
