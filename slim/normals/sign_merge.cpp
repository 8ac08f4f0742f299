#include "slim/normals/sign_merge.h"

#include "slim/normals/pair_weights.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

namespace slim {
namespace {

constexpr std::size_t kMany = std::size_t{1} << 16;
// least weights of pairs in the queue, one after the other: a queue of all pairs is too large for a
// cache
constexpr double kQueued[] = {64, 16, 4, 1, 0.25, 0};

/// The votes between groups that still stand for themselves.
class VoteGraph {
public:
    VoteGraph(std::uint32_t n, const std::vector<SignVote>& votes)
        : neighbors_(n), alive_(n, true), weights_(votes.size()) {
        for (const SignVote& v : votes) add(v.a, v.b, v.weight);
    }

    /// Queues the pairs of at least that weight, now and as they come. None may be queued before.
    void queue_from(double least) {
        least_ = least;
        std::vector<Sure> pairs;
        weights_.for_each([&](std::uint32_t a, std::uint32_t b, double weight) {
            if (std::abs(weight) >= least) pairs.push_back({std::abs(weight), a, b});
        });
        queue_ = std::priority_queue<Sure>({}, std::move(pairs));
    }

    /// Takes the surest pair, joins it in `forest` and adds up their votes; false: none is queued.
    bool merge_surest(SignedForest& forest) {
        while (!queue_.empty()) {
            const Sure sure = queue_.top();
            queue_.pop();
            const std::size_t at = weights_.find(sure.a, sure.b);
            if (at == PairWeights::kNone || std::abs(weights_.weight(at)) != sure.weight) continue;
            const bool opposed = weights_.weight(at) < 0;
            weights_.erase(at);
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

    /// Returns what a and b say of each other now.
    double add(std::uint32_t a, std::uint32_t b, double weight) {
        const auto [at, is_new] = weights_.add(a, b, weight);
        if (is_new) {
            neighbors_[a].push_back(b);
            neighbors_[b].push_back(a);
        }
        return weights_.weight(at);
    }
    /// What `from` says of others is said by `to`.
    void move_votes(std::uint32_t from, std::uint32_t to, bool opposed) {
        alive_[from] = false;
        for (const std::uint32_t other : neighbors_[from]) {
            if (!alive_[other] || other == to) continue;
            const std::size_t at = weights_.find(from, other);
            if (at == PairWeights::kNone) continue;
            const double weight = opposed ? -weights_.weight(at) : weights_.weight(at);
            weights_.erase(at);
            const double sure = std::abs(add(to, other, weight));
            if (sure >= least_) queue_.push({sure, std::min(to, other), std::max(to, other)});
        }
        neighbors_[from] = {};
    }

    std::vector<std::vector<std::uint32_t>> neighbors_;  ///< some no longer alive
    std::vector<bool> alive_;
    PairWeights weights_;
    std::priority_queue<Sure> queue_;
    double least_ = 0;
};

}  // namespace

void add_up(std::vector<SignVote>& votes) {
    // A task that waited for others' work in the sort of a few would take up another of its kind.
    if (votes.size() > kMany) tbb::parallel_sort(votes.begin(), votes.end());
    else std::sort(votes.begin(), votes.end());
    std::size_t n = 0;
    for (const SignVote& vote : votes)
        if (n > 0 && votes[n - 1].a == vote.a && votes[n - 1].b == vote.b)
            votes[n - 1].weight += vote.weight;
        else votes[n++] = vote;
    votes.resize(n);
}

SignedForest merge_by_votes(std::uint32_t n, std::vector<SignVote> votes) {
    SignedForest forest(n);
    VoteGraph graph(n, votes);
    votes = {};
    for (const double least : kQueued) {
        graph.queue_from(least);
        while (graph.merge_surest(forest)) {}
    }
    return forest;
}

}  // namespace slim
