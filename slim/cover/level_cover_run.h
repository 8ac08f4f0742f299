#pragma once

#include "slim/base/parallel.h"
#include "slim/cover/cover_states.h"
#include "slim/cover/leaf_maker.h"
#include "slim/cover/level_cover.h"
#include "slim/cover/second_fit.h"

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

namespace slim {

/// Of a centre of a batch: another may forestall it, it is searched next, it was.
enum class SearchStage : std::uint8_t { held, next, done };

/// What the last centres became that others may stand near, the later the more they count.
class LatestKinds {
public:
    void add(bool is_leaf) { internal_ += ((is_leaf ? 0 : 1) - internal_) / kRemembered; }
    bool are_often_internal() const { return internal_ > kOften; }

private:
    static constexpr double kRemembered = 32, kOften = 0.1;
    double internal_ = 1;  // share
};

/// One centre of a batch and what its search found.
struct CoverCandidate : LeafCandidate {
    SearchStage stage = SearchStage::held;
    bool few_in_noise = false;           // a forced ball of so few points that it
                                         // gives way to a leaf beside it
    FittedSurfel internal;               // if it is no leaf
    std::vector<std::uint32_t> stamped;  // points that the internal surfel
                                         // keeps from becoming centres
    bool is_accepted = false, is_kept = false;  // as a leaf
};

/// The state of one run; each method is one step of it. Holds references to all it is given.
class LevelCover {
public:
    LevelCover(const PointBlock& points, const CoverRules& rules, const PointPyramid& pyramid);
    Cover run(Reporter& reporter);

private:
    bool owns(const Vec3d& p) const { return !rules_.owns || rules_.owns(p); }
    bool is_kept(const FittedSurfel& f) const;
    void mark_done();
    void mark_again(std::span<const FittedSurfel> leaves);
    void keep(const FittedSurfel& f);
    std::size_t thinning_for(double radius) const;
    bool is_closed(std::uint32_t rank) const;
    bool sift_open(std::size_t thinning);
    void run_level(int level, std::size_t thinning);
    void run_pass(int level, std::size_t thinning, float most_overlap,
                  const std::vector<std::uint32_t>& waiting);
    template <class IsWanted>
    std::size_t fill_batch(const std::vector<std::uint32_t>& ready, std::size_t next, int level,
                           const IsWanted& is_wanted, std::vector<CoverCandidate>& batch) const;
    template <class IsWanted>
    std::size_t decide(std::vector<CoverCandidate>& batch, int level, const IsWanted& is_wanted);
    void settle_aside(std::vector<CoverCandidate>& batch, std::size_t n);
    void settle(std::vector<CoverCandidate>& batch);
    void search(CoverCandidate& c, int level, std::size_t thinning);
    void make_internal(CoverCandidate& c, double radius, std::size_t thinning,
                       LeafWork& work) const;
    void finish_leaves();
    void for_known_leaves(const SurfelVisit& visit) const;
    void accept(CoverCandidate& c, int level);
    void accept_leaf(CoverCandidate& c, int level);
    bool drop(std::uint32_t point);
    void mark(const CoveringSurfel& leaf);
    /// Gaps between leaves are told once all are known. Raw scans have holes and rims of their own;
    /// the paper's rule is left as it is.
    bool closes_gaps() const {
        return (rules_.refits || !is_raw()) && !rules_.windows && rules_.last_level == kLastLevel &&
               !rules_.is_sample();
    }
    bool is_raw() const { return rules_.ladder.contrary_share >= kCleanNormals; }

    const PointBlock& block_;
    const CoverRules& rules_;
    const PointPyramid& pyramid_;
    LeafMaker leaves_;
    CoverStates states_;
    SecondFit second_;
    std::deque<FittedSurfel> known_;  // the leaves, if gaps are closed and none waits for that fit
    std::vector<std::uint64_t> strays_;  // their ids
    LatestKinds forestalling_;
    // places in by_priority() of points that may be open, rising
    std::vector<std::uint32_t> open_;
    std::size_t n_open_;  // when they were last sifted
    tbb::enumerable_thread_specific<LeafWork> work_;
    Cover out_;
    CoverCounts of_leaves_;                // of what is settled
    std::vector<CoverCandidate> settled_;  // a batch that was accepted, until it is
    WorkAside aside_;                      // last: it refers to all above
};

}  // namespace slim
