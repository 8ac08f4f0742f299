#include "slim/normals/sign_groups.h"

#include "slim/base/parallel.h"
#include "slim/normals/sign_vote.h"
#include "slim/normals/signed_forest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace slim {
namespace {

// rows of the graph whose points may be in one group: larger groups would take the word of a single
// pair for that of many (notes/0002)
constexpr std::size_t kRows = 64;
constexpr std::size_t kGrain = 1024;  // rows a task
// pairs are joined by rising 1 - |vote|; 0.1 is within 26 degrees on a plane
constexpr std::array<float, 8> kClasses = {1e-3f, 3e-3f, 0.01f, 0.03f, 0.1f, 0.2f, 0.4f, 0.7f};
// more only where, in thick noise, groups are fewer than kPoints large
constexpr std::size_t kSureClasses = 5;
constexpr std::size_t kPoints = 5;

constexpr float kSmall = 1e-30f;  // square of a length whose products floats hold
constexpr double kLeast = 1e-300;

/// The vote of a pair of points, whose distance may leave the floats.
float vote_of_pair(const PointBlock& points, std::uint32_t a, std::uint32_t b) {
    const Vec3d apart = points.position[b] - points.position[a];
    const Vec3f &m = points.normal[a], &n = points.normal[b];
    Vec3f line = to_float(apart);
    float square = sq_length(line);
    if (!(square > kSmall && square < 1 / kSmall)) {  // squares leave the floats
        line = normalized(to_float(
            apart / std::max({std::abs(apart.x), std::abs(apart.y), std::abs(apart.z), kLeast})));
        square = 1;
    }
    return sign_vote(m, n, line, square);
}

struct Pair {
    float vote;
    std::uint32_t a, b;  ///< rows of a block
};

/// The pairs of neighbours in rows [begin, end) that may be in one group, rows relative to begin.
void list_pairs(const PointBlock& points, const NeighborGraph& graph,
                const std::vector<bool>& known, std::size_t begin, std::size_t end, float most,
                std::vector<Pair>& pairs) {
    pairs.clear();
    const std::span rows(graph.points.data() + begin, end - begin);
    const bool is_whole = rows.back() - rows.front() + 1 == rows.size();  // no point is left out
    for (std::uint32_t a = 0; a < rows.size(); ++a) {
        const std::uint32_t i = rows[a];
        if (known[i]) continue;
        for (const std::uint32_t j : graph.of(begin + a)) {
            if (j == i || j < rows.front() || j > rows.back() || known[j]) continue;
            const auto b = is_whole ? j - rows.front()
                                    : static_cast<std::uint32_t>(std::ranges::lower_bound(rows, j) -
                                                                 rows.begin());
            if (rows[b] != j) continue;
            const float vote = vote_of_pair(points, i, j);
            if (1 - std::abs(vote) < most) pairs.push_back({vote, a, b});
        }
    }
}

void join_pairs(const std::vector<Pair>& pairs, std::span<const float> classes,
                SignedForest& forest) {
    float least = -1;  // rounding may leave a vote above 1
    for (const float most : classes) {
        for (const Pair& p : pairs) {
            const float doubt = 1 - std::abs(p.vote);
            if (doubt < most && doubt >= least) forest.join(p.a, p.b, p.vote < 0);
        }
        least = most;
    }
}

/// Numbers the groups of rows [begin, end) from 0; returns how many they are.
std::uint32_t number_groups(const NeighborGraph& graph, const std::vector<bool>& known,
                            std::size_t begin, std::size_t end, SignedForest& forest,
                            SignGroups& groups) {
    constexpr std::uint32_t kNone = ~0u;
    std::array<std::uint32_t, kRows> number;
    number.fill(kNone);
    std::uint32_t n = 0;
    for (std::size_t row = begin; row < end; ++row) {
        const std::uint32_t i = graph.points[row];
        if (known[i]) continue;
        const SignedForest::Root root = forest.find(static_cast<std::uint32_t>(row - begin));
        if (number[root.index] == kNone) number[root.index] = n++;
        groups.of[i] = number[root.index];
        groups.opposed[i] = root.flipped;
    }
    return n;
}

SignGroups group_by_classes(const PointBlock& points, const NeighborGraph& graph,
                            const std::vector<bool>& known, std::span<const float> classes) {
    SignGroups groups;
    groups.of.assign(points.size(), SignGroups::kKnown);
    groups.opposed.assign(points.size(), 0);
    const std::size_t n_rows = graph.points.size();
    std::vector<std::uint32_t> counts((n_rows + kRows - 1) / kRows);
    parallel_blocks(n_rows, kRows, [&](std::size_t begin, std::size_t end) {
        thread_local std::vector<Pair> pairs;
        list_pairs(points, graph, known, begin, end, classes.back(), pairs);
        SignedForest forest(end - begin);
        join_pairs(pairs, classes, forest);
        counts[begin / kRows] = number_groups(graph, known, begin, end, forest, groups);
    });
    for (std::size_t block = 0; block < counts.size(); ++block) {
        for (std::size_t row = block * kRows; row < std::min(n_rows, (block + 1) * kRows); ++row)
            if (const std::uint32_t i = graph.points[row]; !known[i]) groups.of[i] += groups.n;
        groups.n += counts[block];
    }
    return groups;
}

/// The votes of rows [begin, end) of the graph, each by itself.
void list_votes(const PointBlock& points, const NeighborGraph& graph, const SignGroups& groups,
                std::size_t begin, std::size_t end, std::vector<SignVote>& votes) {
    votes.clear();
    for (std::size_t row = begin; row < end; ++row) {
        const std::uint32_t i = graph.points[row];
        for (const std::uint32_t j : graph.of(row)) {
            const auto [a, b] = std::minmax(groups.of[i], groups.of[j]);
            if (a == b) continue;
            const float vote = vote_of_pair(points, i, j);
            const float weight = vote * std::abs(vote);
            votes.push_back({a, b, groups.opposed[i] == groups.opposed[j] ? weight : -weight});
        }
    }
}

}  // namespace

SignGroups group_by_sign(const PointBlock& points, const NeighborGraph& graph,
                         const std::vector<bool>& known) {
    SignGroups groups;
    for (std::size_t n = kSureClasses; n <= kClasses.size(); ++n) {
        groups = group_by_classes(points, graph, known, std::span(kClasses).first(n));
        if (kPoints * groups.n <= graph.points.size()) break;
    }
    return groups;
}

std::vector<SignVote> votes_between(const PointBlock& points, const NeighborGraph& graph,
                                    const SignGroups& groups) {
    const std::size_t n_rows = graph.points.size();
    std::vector<std::vector<SignVote>> parts((n_rows + kGrain - 1) / kGrain);
    parallel_blocks(n_rows, kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<SignVote> votes, some;
        for (std::size_t first = begin; first < end; first += kRows) {
            list_votes(points, graph, groups, first, std::min(first + kRows, end), some);
            add_up(some);
            votes.insert(votes.end(), some.begin(), some.end());
        }
        parts[begin / kGrain] = {votes.begin(), votes.end()};
    });
    std::vector<SignVote> votes;
    std::size_t n = 0;
    for (const std::vector<SignVote>& part : parts) n += part.size();
    votes.reserve(n);
    for (std::vector<SignVote>& part : parts) {
        votes.insert(votes.end(), part.begin(), part.end());
        part = {};
    }
    add_up(votes);
    return votes;
}

}  // namespace slim
