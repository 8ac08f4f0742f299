#include "slim/fit/sharp_fit.h"

#include "slim/fit/fitted_sheets.h"
#include "slim/fit/sharp_clusters.h"
#include "slim/fit/sharp_measure.h"
#include "slim/fit/sheet_by_normals.h"
#include "slim/model/surfel_tree.h"
#include "slim/model/weight_kernel.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace slim {
namespace {

constexpr double kWorthADegree = 1.5;  // eps^2 of the plane over that of the full degree
constexpr double kFollows = 0.9;       // mean cosine of a sheet's gradients to its points' normals
constexpr int kRefits = 2;

template <class T>
void reserve_part(BallPoints<T>& part, std::size_t n) {
    const std::size_t size = n + 64;
    if (part.x.size() >= size) return;
    for (auto* a : {&part.x, &part.y, &part.z, &part.sq}) a->resize(2 * size);
    for (auto* a : {&part.nx, &part.ny, &part.nz}) a->resize(2 * size);
}

/// The points of sheet k as a ball of their own; normals of those that are its alone.
template <class T>
void gather_part(const BallPoints<T>& p, const std::vector<std::uint8_t>& sheets, std::size_t k,
                 BallPoints<T>& part) {
    reserve_part(part, p.n);
    part.radius = p.radius;
    part.weight = p.weight;
    std::size_t n = 0;
    for (std::size_t i = 0; i < p.n; ++i) {
        part.x[n] = p.x[i], part.y[n] = p.y[i], part.z[n] = p.z[i], part.sq[n] = p.sq[i];
        const float own = sheets[i] == 1u << k ? 1.0f : 0.0f;
        part.nx[n] = own * p.nx[i], part.ny[n] = own * p.ny[i], part.nz[n] = own * p.nz[i];
        n += (sheets[i] >> k) & 1u;
    }
    part.n = n;
    for (std::size_t i = n; i < part.padded(); ++i) {
        part.x[i] = part.y[i] = part.z[i] = T(0);
        part.sq[i] = T(2);
        part.nx[i] = part.ny[i] = part.nz[i] = 0;
    }
}

/// One fit while it is improved.
template <class T>
class SharpFitter {
public:
    SharpFitter(const BallPoints<T>& points, int degree, double noise_variance, SharpWork<T>& work)
        : p_(points),
          degree_(degree),
          noise_(std::sqrt(noise_variance) / points.radius),
          work_(work) {}

    std::optional<SharpFit> run(std::size_t n_sheets) {
        NormalClusters clusters;
        fit_.n_sheets = n_sheets;
        if (!cluster_normals(p_, n_sheets, clusters, work_.sheets)) return std::nullopt;
        for (std::size_t k = 0; k < n_sheets; ++k)
            fit_.frame[k] = frame_from_normal(round_normal(clusters.normal[k]));
        if (!fit_sheets()) return std::nullopt;
        for (int i = 0; i < kRefits && assign(); ++i)
            if (!fit_sheets()) return std::nullopt;
        find_joins();
        measure_sharp(p_, noise_, sheets_, work_);
        return fit_;
    }

private:
    /// The fit of the full degree to the points of a sheet, those in work_.part; of few, by their
    /// normals too.
    LocalFit full_fit(std::size_t k) {
        const LocalFit full = fit_ball(work_.part, 1, fit_.frame[k], degree_);
        return full.degree > 1 ? full : fit_by_normals(work_.part, fit_.frame[k]).value_or(full);
    }

    /// Each sheet to its own points; the plane if the full degree is not clearly better: a sheet
    /// must not swing where it has no points.
    bool fit_sheets() {
        fit_.degree = 1;
        fit_.n_coefficients = 0;
        for (std::size_t k = 0; k < fit_.n_sheets; ++k) {
            gather_part(p_, work_.sheets, k, work_.part);
            LocalFit best = fit_ball(work_.part, 1, fit_.frame[k], 1);
            if (!(best.n_effective > 0)) return false;
            if (degree_ > 1) {
                const LocalFit full = full_fit(k);
                if (full.degree > 1 && kWorthADegree * full.sq_error < best.sq_error) best = full;
            }
            sheets_.set(k, best);
            if (!follows_normals(k)) sheets_.set(k, best = level(k));
            error_[k] = std::sqrt(best.sq_error) / p_.radius;
            fit_.degree = std::max(fit_.degree, best.degree);
            fit_.n_coefficients += n_coefficients(best.degree);
        }
        return true;
    }

    /// Whether a sheet's gradients are the normals of the points that are its alone. A plane
    /// through a few points of a narrow strip may lean away from them.
    bool follows_normals(std::size_t k) const {
        double sum = 0, n = 0;
        for (std::size_t i = 0; i < p_.n; ++i) {
            const Vec3d normal = p_.normal(i);
            if (work_.sheets[i] != 1u << k || !(sq_length(normal) > 0)) continue;
            sum += sheets_.cosine(k, p_.place(i), normal);
            ++n;
        }
        return sum >= kFollows * n;
    }

    /// The plane across the mean normal through the mean of the sheet's points (those in
    /// work_.part).
    LocalFit level(std::size_t k) {
        double sum = 0, squares = 0, weight = 0;
        for (std::size_t i = 0; i < work_.part.n; ++i) {
            const double w = dot(fit_.frame[k].normal, work_.part.place(i));
            const double g = static_cast<double>(fit_weight(p_.weight, work_.part.sq[i]));
            sum += g * w, squares += g * w * w, weight += g;
        }
        LocalFit fit;
        fit.polynomial.a[0] = sum / weight;
        fit.sq_error =
            p_.radius * p_.radius * std::max(0.0, squares / weight - std::pow(sum / weight, 2));
        return fit;
    }

    /// Points go to the sheet whose normal they have, and to every other that is nearly as good and
    /// that they lie on: an edge's own points are on both. Whether that changed anything: if not,
    /// nor would fits.
    bool assign() {
        bool changed = false;
        std::array<std::array<double, kMostSheets>, kMostSheets> apart{};  // 1 - cos
        for (std::size_t a = 0; a < fit_.n_sheets; ++a)
            for (std::size_t b = 0; b < fit_.n_sheets; ++b)
                apart[a][b] = 1 - dot(fit_.frame[b].normal, fit_.frame[a].normal);
        for (std::size_t i = 0; i < p_.n; ++i) {
            const Vec3d x = p_.place(i), n = p_.normal(i);
            std::array<double, kMostSheets> cosines{};
            std::size_t best = 0;
            for (std::size_t k = 0; k < fit_.n_sheets; ++k) {
                cosines[k] = sheets_.cosine(k, x, n);
                if (cosines[k] > cosines[best]) best = k;
            }
            unsigned bits = 0;
            for (std::size_t k = 0; k < fit_.n_sheets; ++k) {
                const bool alike =
                    k == best || cosines[k] >= cosines[best] - kAmbiguous * apart[best][k];
                const double tolerance = kExplained * std::max(error_[k], noise_);
                if (alike && cosines[k] >= kLeastCos && std::abs(sheets_.value(k, x)) <= tolerance)
                    bits |= 1u << k;
            }
            changed |= work_.sheets[i] != bits;
            work_.sheets[i] = static_cast<std::uint8_t>(bits);
        }
        return changed;
    }

    void find_heights() {
        if (work_.heights.size() < p_.n) work_.heights.resize(2 * p_.n);
        for (std::size_t i = 0; i < p_.n; ++i) {
            if (!work_.sheets[i]) continue;
            for (std::size_t k = 0; k < fit_.n_sheets; ++k)
                work_.heights[i][k] = sheets_.value(k, p_.place(i));
        }
    }

    void find_joins() {
        find_heights();
        const WayToJoin way = best_way_to_join(fit_.n_sheets, {work_.heights.data(), p_.n},
                                               {work_.sheets.data(), p_.n});
        fit_.outer = way.outer;
        fit_.inner = way.inner;
        sheets_.put_first(way.first);
    }

    const BallPoints<T>& p_;
    int degree_;
    double noise_;  // relative to the radius
    SharpWork<T>& work_;
    FittedSheets sheets_;
    SharpFit& fit_ = sheets_.fit;
    std::array<double, kMostSheets> error_{};  // eps of each sheet, relative
};

}  // namespace

Surfel SharpFit::surfel(const Vec3d& center, double radius) const {
    Surfel s{center, radius, frame[0], polynomial[0], degree, nullptr};
    SharpSheets more;
    more.n_extra = n_sheets - 1;
    for (std::size_t k = 1; k < n_sheets; ++k) more.extra[k - 1] = {frame[k], polynomial[k]};
    more.outer = outer;
    more.inner = inner;
    s.sharp = std::make_shared<const SharpSheets>(more);
    return s;
}

template <class T>
std::optional<SharpFit> fit_sharp(const BallPoints<T>& points, std::size_t n_sheets, int degree,
                                  double noise_variance, SharpWork<T>& work) {
    return SharpFitter<T>(points, degree, noise_variance, work).run(n_sheets);
}

template std::optional<SharpFit> fit_sharp(const BallPoints<float>&, std::size_t, int, double,
                                           SharpWork<float>&);
template std::optional<SharpFit> fit_sharp(const BallPoints<double>&, std::size_t, int, double,
                                           SharpWork<double>&);

}  // namespace slim
