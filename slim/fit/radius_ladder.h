#pragma once

#include "slim/fit/local_fit.h"
#include "slim/fit/mdl_energy.h"
#include "slim/fit/parallel_sheet.h"
#include "slim/fit/sharp_clusters.h"
#include "slim/fit/sharp_fit.h"
#include "slim/neighbors/point_pyramid.h"

#include <optional>
#include <span>
#include <vector>

namespace slim {

/// How the radius of a surfel is searched; the defaults are chosen by measurement
/// (slim/fit/notes/0001, slim/cover/notes/0001).
struct LadderRules {
    double points_per_coefficient = 3;    ///< of the finest admissible rung (slim/cover/notes/0002)
    double give_up = 3;                   ///< stop where E exceeds this many
                                          ///< times the least upper bound
    /// Of the cloud's normals that noise turns: as many off the sheet are tolerated.
    double contrary_share = 0;
    /// eps^2 that every ball has, whether its points show it or not: those of one step of the
    /// coordinates lie on a plane (notes/0023).
    double least_sq_error = 0;
    /// Past another sheet, over rho: of the points' mean off the centre (parallel_sheet.h).
    double most_lean = kLeanOfBorder;
    std::size_t sample = 512;             ///< most points of a rung, a larger ball is thinned
    std::size_t most_sample = 4096;       ///< and of one that shows noise alone
    /// Each centre takes the degree that E favours, its price by bytes (notes/0004);
    /// else all the same.
    bool choose_degree = false;
    bool look_for_edges = false;          ///< whether to fill in LadderWork::edge_in_sight
    int above_root = 5;                   ///< rungs above rho_0 tried where
                                          ///< rho_0 holds too few points
    int top_rung = 0;                     ///< the coarsest that may be chosen: > 0 where the points
                                          ///< end near by; none above it is tried then
};

/// What the search found for one centre.
struct RadiusChoice {
    double radius = 0;
    int degree = 0;          ///< asked of the fit there
    bool saturated = false;  ///< the top rung won: E still falls there
    bool forced = false;     ///< no admissible rung: too few points or no height field
    bool isolated = false;   ///< a stray: no ball up to the largest tried holds
                             ///< enough points, or the first that does is at least
                             ///< rho_0 and has nobody near its centre
    bool limited = false;    ///< the coarsest admissible rung won, or there was none: a fold or
                             ///< another sheet ended the ladder, not E
    double energy = 0;       ///< E there; of a forced one that of a
                             ///< leaf that is as good as the noise
    double finest = 0;       ///< radius of the finest admissible rung
    bool widened = false;    ///< past what limited it: the plain fit of the
                             ///< larger ball allows it (slim/cover/notes/0012)
    bool past_sheet = false; ///< its ball also holds another sheet (slim/cover/notes/0017)
};

/// Whether so many of n points may disagree: what noise explains,
/// mean + 3 sigma of a Poisson count.
bool within_noise(std::size_t count, std::size_t n, double share);

/// Workspace of one thread and the counts it keeps.
struct LadderWork {
    BallPoints<float> ball;
    std::size_t level = 0;  ///< of the pyramid, that a ladder gathered it from
    std::vector<SetAside<float>> aside;
    SharpWork<float> sharp;
    bool edge_in_sight = false;  ///< shows_edge or shows_faces of the last search's last rung
    std::size_t rungs = 0, point_visits = 0, refinements = 0, sharp_rungs = 0;
};

/// Searches the radius of the surfel about a point by the whole ladder rho_0 g^j (DESIGN 4, lessons
/// 2 and 3): the largest rung that is no worse than any other, noise and bias told apart
/// (notes/0005), then a minimum of E between its neighbours. Depends on the points alone, never on
/// surfels made before.
class RadiusLadder {
public:
    /// root_radius: rho_0; least_radius: below it coordinates are rounding. `points` must outlive
    /// this.
    RadiusLadder(const PointPyramid& points, const MdlEnergy& energy, double root_radius,
                 double least_radius, int degree, const LadderRules& rules);

    /// center, normal: of a point; first_guess: a length near the distance of its neighbours.
    /// Cost: about rules.sample points a rung, five more evaluations to refine.
    RadiusChoice choose(const Vec3d& center, const Vec3d& normal, double first_guess,
                        LadderWork& work) const;

    double rung_radius(int rung) const;
    int last_rung() const { return last_rung_; }

private:
    struct Rung {
        int index;
        std::size_t level;     // of the pyramid
        int degree;            // of the least energy, if it is chosen
        SheetEnd end;          // not `ends`
        std::size_t n;         // points of its ball
        double energy, upper;  // E, and two standard errors above it
        double noise, noise_upper;    // eps^2 without what the next degree
                                      // would find, and two errors more
        double missed, missed_error;  // that and the price lambda (T L / rho)^2; two errors
        double sq_radius;
        double slope, slope_upper;    // mean square that slopes are off even with the next degree,
                                      // two standard errors above it; 0 where normals do not count
    };
    /// Index of the largest ball that is no worse than any other,
    /// of rungs by falling radius (notes/0005).
    static int largest_as_good(std::span<const std::optional<Rung>> rungs);
    /// A rung's fit to the points gathered in the workspace.
    struct LadderFit {
        Frame<double> frame;
        int degree;
        LocalFit fit;
    };
    MdlEnergy energy_of(int degree) const;
    void fit_cheapest(const BallPoints<float>& ball, LadderFit& out) const;
    LadderFit fit_gathered(const Vec3d& normal, LadderWork& work) const;
    std::size_t least_points() const;
    int coarsest_tried() const {
        return rules_.top_rung > 0 ? rules_.top_rung : -rules_.above_root;
    }
    bool stands_alone(const Vec3d& center, int rung) const;
    int finest_rung(const Vec3d& center, double first_guess, LadderWork& work) const;
    std::size_t likely_level(const Rung& finer) const;
    void gather(std::size_t level, const Vec3d& center, double radius, LadderWork& work) const;
    void gather_again(std::size_t level, const Vec3d& center, double radius,
                      LadderWork& work) const;
    void gather_rung(int rung, std::size_t& level, const Vec3d& center, LadderWork& work) const;
    SheetEnd end_of(const LadderFit& found, const LadderWork& work) const;
    std::optional<Rung> evaluate(int rung, std::size_t level, const Vec3d& center,
                                 const Vec3d& normal, LadderWork& work) const;
    bool falls_to_the_end(const Rung& chosen, const Rung& finer) const;
    double known_optimum(const Rung& chosen, double lo, double hi) const;
    double refine(const Rung& chosen, double lo, double hi, const Vec3d& center,
                  const Vec3d& normal, LadderWork& work) const;

    const PointPyramid& points_;
    MdlEnergy energy_;
    double root_radius_, least_radius_;
    std::vector<double> radii_;  // of the rungs from the one above the coarsest tried on
    int degree_;
    LadderRules rules_;
    int last_rung_;
};

}  // namespace slim
