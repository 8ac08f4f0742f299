#include "slim/model/surfel_encoder.h"

#include "slim/base/bbox.h"
#include "slim/base/check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>

namespace slim {
namespace {

/// A plane in a frame whose slopes are zero.
Sheet level_plane(const Sheet& s) {
    const auto& a = s.polynomial.a;
    // Gradient of f = w - a0 - a1 u - a2 v; the plane's distance to the centre along the new
    // normal.
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

/// A rim in other axes of nearly the same plane: the nearest direction, a step farther as it turned
/// a little.
PackedRim turn_rim(PackedRim packed, const Frame<double>& from, const Frame<double>& to) {
    if (packed == 0 || from.normal == to.normal) return packed;
    const Rim rim = unpack_rim(packed);
    const Vec3d outwards = from.u_axis * rim.u + from.v_axis * rim.v;
    const double angle = std::atan2(dot(to.v_axis, outwards), dot(to.u_axis, outwards));
    const long k = std::lround(angle * kRimDirections / (2 * std::numbers::pi));
    return pack_rim(static_cast<int>((k + kRimDirections) % kRimDirections),
                    rim.reach + 0.5 * kRimStep);
}

/// What is left of them if one reaches too far now comes first.
PackedRims turn_rims(PackedRims rims, const Frame<double>& from, const Frame<double>& to) {
    const PackedRim first = turn_rim(rims.first, from, to),
                    second = turn_rim(rims.second, from, to);
    if (first == 0) return {second, 0};
    return {first, second};
}

}  // namespace

Surfel level_linear(const Surfel& s) {
    if (s.degree > 1) return s;
    const Sheet own = level_plane({s.frame, s.polynomial});
    Surfel out = s;
    out.rims = turn_rims(s.rims, s.frame, own.frame);
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

}  // namespace

SurfelEncoder::SurfelEncoder(std::size_t n, const Shapes& shape, SurfelTreeData& out) : out_(out) {
    out.page_origins.clear();
    out.sharp.clear();
    lay_out_records(n, shape);
    std::size_t n_sheets = 0;
    for (std::size_t page = 0; page < n; page += kSurfelsPerPage) {
        Bbox box;
        for (std::size_t i = page; i < std::min(n, page + kSurfelsPerPage); ++i) {
            const SurfelShape s = shape(i);
            box.extend(s.center);
            if (s.n_extra == 0) continue;
            out.sharp.push_back({static_cast<std::uint32_t>(i),
                                 static_cast<std::uint32_t>(n_sheets), s.n_extra, 0, 0, 0});
            n_sheets += s.n_extra;
        }
        out.page_origins.push_back(box.center());
    }
    n_sheet_floats_ = n_sheets * static_cast<std::size_t>(floats_per_sheet(out.header.degree));
}

/// Not before the first surfel: whoever announced the shapes may have no more use for them by then.
void SurfelEncoder::make_room() {
    out_.records.assign(n_record_floats_, 0.0f);
    out_.sheets.assign(n_sheet_floats_, 0.0f);
}

/// Says where the records will stand, by the surfels' own degrees if that takes clearly fewer
/// bytes, index included.
void SurfelEncoder::lay_out_records(std::size_t n, const Shapes& shape) {
    out_.page_start.clear();
    out_.in_page.clear();
    std::size_t packed = 0;
    for (std::size_t i = 0; i < n; ++i) packed += record_floats(shape(i).degree);
    const std::size_t equal = n * record_floats(out_.header.degree);
    const std::size_t n_pages = (n + kSurfelsPerPage - 1) / kSurfelsPerPage;
    const std::size_t index = 2 * n + 8 * n_pages;
    const bool is_packed = static_cast<double>(sizeof(float) * packed + index) <
                           kWorthAnIndex * static_cast<double>(sizeof(float) * equal);
    n_record_floats_ = is_packed ? packed : equal;
    out_.records.clear();
    if (!is_packed) return;
    out_.page_start.reserve(n_pages);
    out_.in_page.reserve(n);
    std::size_t at = 0;
    for (std::size_t i = 0; i < n; ++i) {
        if (i % kSurfelsPerPage == 0) out_.page_start.push_back(at);
        out_.in_page.push_back(static_cast<std::uint16_t>(at - out_.page_start.back()));
        at += record_floats(shape(i).degree);
    }
}

PackedRims SurfelEncoder::put(std::size_t node, const Surfel& surfel) {
    if (out_.records.empty()) make_room();
    const bool packed = !out_.in_page.empty();
    const int degree = packed ? surfel.degree : out_.header.degree;
    const Surfel s = degree <= 1 ? level_linear(surfel) : surfel;
    const std::size_t page = node / kSurfelsPerPage;
    const std::size_t size = record_floats(degree);
    const std::size_t at = packed ? out_.page_start[page] + out_.in_page[node] : node * size;
    SLIM_CHECK(at + size, <=, out_.records.size());
    float* r = out_.records.data() + at;
    const Vec3f c = to_float(s.center - out_.page_origins[page]);
    r[0] = c.x, r[1] = c.y, r[2] = c.z;
    r[3] = static_cast<float>(s.support_radius);
    put_sheet({s.frame, s.polynomial}, {r + 4, size - 4});
    if (s.sharp) put_further_sheets(node, *s.sharp);
    return s.rims;
}

void SurfelEncoder::put_further_sheets(std::size_t node, const SharpSheets& more) {
    const auto entry =
        std::lower_bound(out_.sharp.begin(), out_.sharp.end(), node,
                         [](const SharpEntry& e, std::size_t n) { return e.node < n; });
    SLIM_CHECK((entry == out_.sharp.end() ? kNoNode : entry->node), ==, node);
    entry->outer = static_cast<std::uint8_t>(more.outer);
    entry->inner = static_cast<std::uint8_t>(more.inner);
    const auto stride = static_cast<std::size_t>(floats_per_sheet(out_.header.degree));
    for (std::size_t k = 0; k < more.n_extra; ++k)
        put_sheet(more.extra[k],
                  std::span(out_.sheets).subspan((entry->first_sheet + k) * stride, stride));
}

void encode_surfels(std::span<const Surfel> surfels, SurfelTreeData& out) {
    SurfelEncoder encoder(surfels.size(), [&](std::size_t i) { return shape_of(surfels[i]); }, out);
    for (std::size_t i = 0; i < surfels.size(); ++i) encoder.put(i, surfels[i]);
}

}  // namespace slim
