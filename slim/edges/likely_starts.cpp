#include "slim/edges/likely_starts.h"

#include "slim/base/joined_sets.h"
#include "slim/edges/edge_walk.h"

#include <span>

namespace slim {
namespace {

constexpr std::size_t kGrain = 64;

/// The leaves' edges about each start, each list behind its start's number and length.
using StartLists = std::vector<std::uint32_t>;

StartLists starts_of(const BallIndex& leaves, const Corners& corners, std::size_t begin,
                     std::size_t end) {
    StartLists lists;
    EdgeWalker walker(leaves, corners);
    for (std::size_t i = begin; i < end; ++i)
        for (std::size_t pair = 0; pair < n_sheet_pairs(leaves.leaf(i)); ++pair)
            if (const auto start = walker.start(i, pair)) {
                lists.push_back(static_cast<std::uint32_t>(kSheetPairs.size() * i + pair));
                lists.push_back(static_cast<std::uint32_t>(start->parts.size()));
                lists.insert(lists.end(), start->parts.begin(), start->parts.end());
            }
    return lists;
}

}  // namespace

std::vector<std::uint32_t> likely_starts(const BallIndex& leaves, const Corners& corners,
                                         const EachBatch& each_batch) {
    std::vector<StartLists> lists((leaves.n_leaves() + kGrain - 1) / kGrain);
    parallel_batches(leaves.n_leaves(), kGrain, each_batch,
                     [&](std::size_t begin, std::size_t end) {
                         lists[begin / kGrain] = starts_of(leaves, corners, begin, end);
                     });
    JoinedSets sets(kSheetPairs.size() * leaves.n_leaves());
    const auto for_each_start = [&](const auto& visit) {
        for (const StartLists& list : lists)
            for (std::size_t at = 0; at < list.size(); at += 2 + list[at + 1])
                visit(list[at], std::span(list).subspan(at + 2, list[at + 1]));
    };
    for_each_start([&](std::uint32_t start, std::span<const std::uint32_t> parts) {
        for (const std::uint32_t part : parts) sets.join(start, part);
    });
    // In order: the first start that is met of each set.
    std::vector<std::uint8_t> has_start(kSheetPairs.size() * leaves.n_leaves(), 0);
    std::vector<std::uint32_t> likely;
    for_each_start([&](std::uint32_t start, std::span<const std::uint32_t>) {
        std::uint8_t& known = has_start[sets.find(start)];
        if (!known) likely.push_back(start);
        known = 1;
    });
    return likely;
}

}  // namespace slim
