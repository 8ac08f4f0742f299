#pragma once

#include "slim/cover/cover_rules.h"
#include "slim/cover/leaf_voids.h"
#include "slim/cover/surfel_fit.h"
#include "slim/fit/radius_ladder.h"
#include "slim/fit/radius_windows.h"
#include "slim/fit/sharp_search.h"
#include "slim/model/point_block.h"
#include "slim/neighbors/point_pyramid.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace slim {

/// One centre, the radius that its search found and the leaf made of it.
struct LeafCandidate {
    std::uint32_t point = 0;
    int level = 1;              ///< that looks at it: where the paper's windows begin
    std::uint32_t center = 0;   ///< where the leaf is centred: at
                                ///< `point`, or at one further inwards
    bool leaf = false;
    RadiusChoice choice;
    std::size_t n_sheets = 1;
    bool sparse = false;        ///< the finest ball is far larger than usual
    CoveringSurfel surfel;      ///< if `leaf`
};

/// Workspace of one thread, and its counts.
struct LeafWork {
    LadderWork ladder;
    SteadyWork exact;
    BallPoints<double> wide;  ///< the largest ball that a leaf might take
    SharpWork<double> sharp;
    std::size_t searches = 0;
};

/// Makes leaves: searches a centre's radius, fits, and mends what stands at borders or among
/// strays. Depends on the points alone, never on leaves made before. Holds references to all it is
/// given.
class LeafMaker {
public:
    LeafMaker(const PointBlock& points, const CoverRules& rules, const PointPyramid& pyramid);

    /// Square root of the area that one of the job's points usually has.
    double spacing() const { return spacing_; }

    /// Fills in choice, n_sheets and sparse of c.point at c.level; cost: one radius search (10 us).
    void choose(LeafCandidate& c, LeafWork& work) const;

    /// Whether a forced ball holds so few points that are_few_in_noise().
    bool is_few_in_noise(const LeafCandidate& c) const;

    /// The leaf of a centre at its radius; at a border, one further inwards or smaller. c.leaf
    /// becomes false if that is less than `lower`: the point waits. Sparse leaves are as small as
    /// their few points, whatever the level. Strays become choice.isolated.
    void make(LeafCandidate& c, double lower, LeafWork& work) const;

    /// A leaf of a point's own, that passes near it along its normal: of the finest ball about it,
    /// or of a smaller one. Where it has n_before such leaves already, of a ball as many rungs
    /// smaller, and through the point itself. Nothing if there is none, as about strays.
    /// leaf_maker_own.cpp.
    std::optional<CoveringSurfel> make_own(std::uint32_t point, int n_before, LeafWork& work) const;

    /// The leaf that a search about a point gives, whatever its level, with its rims and flags.
    /// Nothing if it does not explain its centre, and about strays. leaf_maker_own.cpp.
    std::optional<CoveringSurfel> make_usual(std::uint32_t point, LeafWork& work) const;

    /// Whether a smooth leaf is thicker than noise makes it where edges are looked for. Such a one
    /// would round off an edge or a corner. leaf_maker_edges.cpp.
    bool rounds_off(const CoveringSurfel& leaf) const;

private:
    static constexpr double kFinestBall = 3.3;    ///< the usual one's radius, in spacings
    /// sqrt(lambda) over the spacing: up to it a single point's plane says enough for larger balls
    /// to be worth their time.
    static constexpr double kLittleNoise = 0.15;

    double spacing_here() const;
    double relative_noise() const;
    bool ends_with_points() const;
    bool passes_over(const CoveringSurfel& leaf) const;
    bool is_too_large(const LeafCandidate& c) const;
    RadiusChoice choose_radius(std::uint32_t place, const Vec3d& normal, int level,
                               LeafWork& work) const;
    /// leaf_maker_edges.cpp: whether edges are looked for, and leaves at them.
    Edges edges() const;
    bool is_clean() const;
    bool are_edges_in_noise() const;
    double share_before_edges(const CoveringSurfel& leaf, const BallPoints<double>& ball) const;
    void sharpen(LeafCandidate& c, const Vec3d& center, LeafWork& work) const;
    CoveringSurfel fit(const Vec3d& center, const Vec3d& normal, const RadiusChoice& choice,
                       LeafWork& work, Lists lists) const;
    CoveringSurfel fit_of_choice(const Vec3d& center, const Vec3d& normal,
                                 const RadiusChoice& choice, LeafWork& work, Lists lists) const;
    void list_with_air(const RadiusChoice& choice, const LeafWork& work,
                       CoveringSurfel& leaf) const;
    CoveringSurfel fit_with_air(const Vec3d& center, const Vec3d& normal,
                                const RadiusChoice& choice, LeafWork& work) const;
    /// Takes the largest of a few larger balls that is accepted. leaf_maker_wider.cpp.
    template <class Accepts>
    void take_wider(LeafCandidate& c, const Vec3d& center, double n_wanted, LeafWork& work,
                    const Accepts& accepts) const;
    void widen(LeafCandidate& c, const Vec3d& center, const Vec3d& normal, LeafWork& work) const;
    void widen_over_plate(LeafCandidate& c, const Vec3d& center, const Vec3d& normal,
                          LeafWork& work) const;
    /// What a sample of a sparse leaf's ball says already. leaf_maker_glance.cpp.
    enum class Glance : std::uint8_t { undecided, scatter, unexplained };
    Glance glance(const LeafCandidate& c, const Vec3d& center, const Vec3d& normal,
                  LeafWork& work) const;
    bool is_among_strays(const LeafCandidate& c, LeafWork& work) const;
    bool leaves_center(const LeafCandidate& c) const;
    void make_whole(LeafCandidate& c, double lower, LeafWork& work) const;
    void shrink_to_few(LeafCandidate& c, LeafWork& work) const;
    static void make_smaller(LeafCandidate& c, double radius, double lower);
    /// leaf_maker_inwards.cpp.
    void end_with_points(const Vec3d& center, const Vec3d& normal, RadiusChoice& choice,
                         LeafWork& work) const;
    std::optional<double> move_inwards(LeafCandidate& c, const Vec3d& inwards, double lower,
                                       LeafWork& work) const;
    /// leaf_maker_voids.cpp.
    LeafVoids voids_in(const CoveringSurfel& leaf, LeafWork& work) const;
    void make_again(LeafCandidate& c, double radius, LeafWork& work) const;
    bool move_from(LeafCandidate& c, int direction, double lower, LeafWork& work) const;
    void keep_voids(LeafCandidate& c, double lower, LeafWork& work) const;

    const PointBlock& block_;
    const CoverRules& rules_;
    const PointPyramid& pyramid_;
    double spacing_;
    RadiusLadder ladder_;
    RadiusWindows windows_;
    SharpSearch sharp_;
    std::vector<std::uint32_t> place_;  // of a point in the pyramid's full tree
};

}  // namespace slim
