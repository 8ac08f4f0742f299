#include "slim/smooth/far_fits.h"

#include <cmath>

namespace slim {
namespace {

std::vector<Surfel> wide_balls(const std::vector<FarFit>& fits) {
    std::vector<Surfel> out;
    out.reserve(fits.size());
    for (const auto& [s, off] : fits) {
        const double reach = std::hypot(s.support_radius, off);
        out.push_back(
            {s.center, reach, s.frame, rescaled(s.polynomial, reach / s.support_radius), 2});
    }
    return out;
}

}  // namespace

FarFits::FarFits(const std::vector<FarFit>& fits) : balls_(wide_balls(fits)) {
    off_.reserve(fits.size());
    for (std::size_t i = 0; i < fits.size(); ++i) off_.push_back(fits[balls_.node(i)].off);
}

std::optional<FarFits::Foot> FarFits::foot(const Vec3d& p, const Vec3d& normal) const {
    std::vector<const Surfel*> found;
    balls_.supporters(p, found);
    const Surfel* nearest = nullptr;
    double least = INFINITY;
    for (const Surfel* s : found) {
        const double sq = sq_length(p - s->center);
        if (sq < least && dot(s->frame.normal, normal) >= 0) least = sq, nearest = s;
    }
    if (!nearest) return std::nullopt;
    const Vec3d& n = nearest->frame.normal;
    const double above = nearest->value((p - nearest->center) / nearest->support_radius);
    return Foot{p - n * (above * nearest->support_radius), n, off_[balls_.number_of(nearest)]};
}

}  // namespace slim
