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
    const auto entry = std::lower_bound(sharp_.begin(), sharp_.end(), i,
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
    if (nodes_[i].flags & kSharp) s.sharp = sharp_sheets(i);
    return s;
}

Vec3d round_normal(const Vec3d& unit_normal) {
    return normal_from_octahedral(octahedral_from_normal(unit_normal));
}

namespace {

/// A plane in a frame whose slopes are zero.
Sheet level_plane(const Sheet& s) {
    const auto& a = s.polynomial.a;
    // Gradient of f = w - a0 - a1 u - a2 v; the plane's distance to the centre along the new normal.
    const double len = std::sqrt(1 + a[1] * a[1] + a[2] * a[2]);
    const Vec3d normal = s.frame.world_from_local({-a[1] / len, -a[2] / len, 1 / len});
    Sheet out{frame_from_normal(round_normal(normal)), {}};
    out.polynomial.a[0] = a[0] / len;
    return out;
}

/// Octahedral normal and as many coefficients as there is room for.
void put_sheet(const Sheet& sheet, std::span<float> out) {
    const Octahedral n = octahedral_from_normal(sheet.frame.normal);
    out[0] = n.s, out[1] = n.t;
    for (std::size_t k = 2; k < out.size(); ++k)
        out[k] = static_cast<float>(sheet.polynomial.a[k - 2]);
}

void put_further_sheets(std::size_t node, const SharpSheets& more, SurfelTreeData& out) {
    const auto stride = static_cast<std::size_t>(floats_per_sheet(out.header.degree));
    out.sharp.push_back({static_cast<std::uint32_t>(node),
                         static_cast<std::uint32_t>(out.sheets.size() / stride),
                         static_cast<std::uint8_t>(more.n_extra),
                         static_cast<std::uint8_t>(more.outer),
                         static_cast<std::uint8_t>(more.inner), 0});
    for (std::size_t k = 0; k < more.n_extra; ++k) {
        out.sheets.resize(out.sheets.size() + stride);
        put_sheet(more.extra[k], std::span(out.sheets).last(stride));
    }
}

}  // namespace

Surfel level_linear(const Surfel& s) {
    if (s.degree > 1) return s;
    const Sheet own = level_plane({s.frame, s.polynomial});
    Surfel out = s;
    out.frame = own.frame;
    out.polynomial = own.polynomial;
    if (!s.sharp) return out;
    SharpSheets more = *s.sharp;
    for (std::size_t k = 0; k < more.n_extra; ++k) more.extra[k] = level_plane(more.extra[k]);
    out.sharp = std::make_shared<const SharpSheets>(more);
    return out;
}

namespace {

std::size_t record_floats(int degree) {
    return static_cast<std::size_t>(floats_per_surfel(degree));
}

constexpr double kWorthAnIndex = 0.95;  // of the bytes of equal records

/// Makes room for the records, by the surfels' own degrees if that takes clearly fewer bytes, index included.
void lay_out_records(std::span<const Surfel> surfels, SurfelTreeData& out) {
    out.page_start.clear();
    out.in_page.clear();
    std::size_t packed = 0;
    for (const Surfel& s : surfels) packed += record_floats(s.degree);
    const std::size_t equal = surfels.size() * record_floats(out.header.degree);
    const std::size_t n_pages = (surfels.size() + kSurfelsPerPage - 1) / kSurfelsPerPage;
    const std::size_t index = 2 * surfels.size() + 8 * n_pages;
    const bool is_packed = static_cast<double>(sizeof(float) * packed + index) <
                           kWorthAnIndex * static_cast<double>(sizeof(float) * equal);
    out.records.assign(is_packed ? packed : equal, 0.0f);
    if (!is_packed) return;
    std::size_t at = 0;
    for (std::size_t i = 0; i < surfels.size(); ++i) {
        if (i % kSurfelsPerPage == 0) out.page_start.push_back(at);
        out.in_page.push_back(static_cast<std::uint16_t>(at - out.page_start.back()));
        at += record_floats(surfels[i].degree);
    }
}

}  // namespace

void encode_surfels(std::span<const Surfel> surfels, SurfelTreeData& out) {
    out.page_origins.clear();
    out.sharp.clear();
    out.sheets.clear();
    lay_out_records(surfels, out);
    const bool packed = !out.in_page.empty();
    std::size_t at = 0;
    for (std::size_t page = 0; page < surfels.size(); page += kSurfelsPerPage) {
        const std::size_t end = std::min(surfels.size(), page + kSurfelsPerPage);
        Bbox box;
        for (std::size_t i = page; i < end; ++i) box.extend(surfels[i].center);
        const Vec3d origin = box.center();
        out.page_origins.push_back(origin);
        for (std::size_t i = page; i < end; ++i) {
            const int degree = packed ? surfels[i].degree : out.header.degree;
            const Surfel s = degree <= 1 ? level_linear(surfels[i]) : surfels[i];
            float* r = out.records.data() + at;
            at += record_floats(degree);
            const Vec3f c = to_float(s.center - origin);
            r[0] = c.x, r[1] = c.y, r[2] = c.z;
            r[3] = static_cast<float>(s.support_radius);
            put_sheet({s.frame, s.polynomial}, {r + 4, record_floats(degree) - 4});
            if (s.sharp) put_further_sheets(i, *s.sharp, out);
        }
    }
}

}  // namespace slim
