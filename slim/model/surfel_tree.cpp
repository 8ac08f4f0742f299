#include "slim/model/surfel_tree.h"

#include "slim/base/check.h"

#include <algorithm>

namespace slim {

Sheet SurfelTree::sheet(const float* r, int degree) {
    Sheet s{frame_from_normal(normal_from_octahedral({r[0], r[1]})), {}};
    const int n = degree <= 1 ? 1 : n_coefficients(degree);
    for (int k = 0; k < n; ++k) s.polynomial.a[static_cast<std::size_t>(k)] = r[2 + k];
    return s;
}

std::shared_ptr<const SharpSheets> SurfelTree::sharp_sheets(std::size_t i) const {
    const auto entry =
        std::lower_bound(sharp_.begin(), sharp_.end(), i,
                         [](const SharpEntry& e, std::size_t n) { return e.node < n; });
    SLIM_CHECK((entry == sharp_.end() ? kNoNode : entry->node), ==, i);
    auto out = std::make_shared<SharpSheets>();
    out->n_extra = entry->n_extra;
    out->outer = static_cast<Join>(entry->outer);
    out->inner = static_cast<Join>(entry->inner);
    const auto stride = static_cast<std::size_t>(floats_per_sheet(header_.degree));
    for (std::size_t k = 0; k < out->n_extra; ++k)
        out->extra[k] = sheet(sheets_.data() + (entry->first_sheet + k) * stride, header_.degree);
    return out;
}

Surfel SurfelTree::surfel(std::size_t i) const {
    const float* r = record(i);
    const Sheet own = sheet(r + 4, record_degree(i));
    Surfel s{center(i), r[3], own.frame, own.polynomial, nodes_[i].degree};
    s.rims = nodes_[i].rims();
    if (nodes_[i].flags & kSharp) s.sharp = sharp_sheets(i);
    return s;
}

Vec3d round_normal(const Vec3d& unit_normal) {
    return normal_from_octahedral(octahedral_from_normal(unit_normal));
}

}  // namespace slim
