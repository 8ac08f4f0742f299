#include "raytrace/lines/crest_look.h"
#include "raytrace/lines/crossings.h"
#include "raytrace/lines/sheet_blur.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace slim {
namespace {

/// One family of crest lines seen as ridges: ravines are those of the surface turned inside out.
struct Family {
    const LineScene& s;
    bool ridges;

    float k(std::size_t i) const { return ridges ? s.buffer.k1[i] : -s.buffer.k2[i]; }
    Vec3f direction(std::size_t i) const {
        const auto& t = s.buffer.direction;
        const Vec3f t1{t[0][i], t[1][i], t[2][i]};
        return ridges ? t1 : cross(s.normal(i), t1);
    }

    /// The same of pixels i, i + 1, ...
    LanesOfVec directions(std::size_t i) const {
        const LanesOfVec t1 = lanes_at(s.buffer.direction, i);
        return ridges ? t1 : lanes_at(s.buffer.normal, i).cross(t1);
    }
    FloatV rates(std::size_t i) const {
        return ridges ? lanes_at(s.buffer.third[0], i) : -lanes_at(s.buffer.third[3], i);
    }
    /// Bits of those more curved than the other way, so that the direction means something.
    std::uint32_t bends(std::size_t i) const {
        const FloatV k1 = lanes_at(s.buffer.k1, i), k2 = lanes_at(s.buffer.k2, i);
        return static_cast<std::uint32_t>(
            lane_bits(ridges ? k1 > stdx::abs(k2) : -k2 > stdx::abs(k1)));
    }
};

/// An edge that the view shows within a pixel (a sheet of sharp surfels against the next, or too
/// fine a rounding): no derivative tells it; its k is the turn over the way.
std::optional<EdgeHit> crease(const Family& f, std::size_t a, std::size_t b) {
    constexpr float kSharp = 4;  // as the sharpest of crest lines
    const Vec3f na = f.s.normal(a), nb = f.s.normal(b), d = f.s.point(b) - f.s.point(a);
    if ((dot(nb - na, d) > 0) != f.ridges) return std::nullopt;
    // Where the tangent planes meet, seen along d.
    const float from_a = std::fabs(dot(nb, d)), from_b = std::fabs(dot(na, d));
    const float at = from_a + from_b > 0 ? from_a / (from_a + from_b) : 0.5f;
    return EdgeHit{at, std::acos(std::clamp(dot(na, nb), -1.0f, 1.0f)) / length(d), kSharp};
}

/// A row of pixels as the search sees it.
struct CrestRow {
    std::vector<std::uint32_t> bends;             ///< bits of kLanes pixels
    std::array<std::vector<float>, 3> direction;  ///< t, of pixels that bend
    std::vector<float> rise;                      ///< dk/dt, averaged

    explicit CrestRow(std::size_t width)
        : bends(width / kLanes + 2, 0), rise(width + 2 * kLanes, 0.0f) {
        for (auto& plane : direction) plane.assign(rise.size(), 0.0f);
    }
    Vec3f t(std::size_t x) const { return {direction[0][x], direction[1][x], direction[2][x]}; }

    /// mean(x): v of the pixels x, x + 1, ..., averaged.
    template <class Mean>
    void fill(const Family& f, const Sheets& sheets, std::size_t y, const Mean& mean) {
        for (std::size_t x = 0; x < sheets.width; x += kLanes) {
            const std::size_t i = y * sheets.width + x;
            const std::uint32_t hit =
                sheets.hit.at(static_cast<std::ptrdiff_t>(y), static_cast<std::ptrdiff_t>(x));
            std::uint32_t& bits = bends[x / kLanes];
            bits = hit != 0 ? f.bends(i) & hit : 0;
            if (bits == 0) continue;
            const LanesOfVec t = f.directions(i);
            const auto v = mean(x);
            LanesOfVec(v[0], v[1], v[2]).dot(t).copy_to(rise.data() + x, stdx::element_aligned);
            t.x.copy_to(direction[0].data() + x, stdx::element_aligned);
            t.y.copy_to(direction[1].data() + x, stdx::element_aligned);
            t.z.copy_to(direction[2].data() + x, stdx::element_aligned);
        }
    }
};

/// How far the directions of two neighbours may turn.
constexpr float kLeastTurn = 0.7f;

/// Bits of the pixels x, x + 1, ... of row `a` that bend as those of row `b` from column x_b on do,
/// and where dk/dt changes its sign between them.
std::uint32_t sign_changes(const CrestRow& a, std::size_t x, const CrestRow& b, std::size_t x_b) {
    std::uint32_t bits = a.bends[x / kLanes];
    const std::uint64_t both = b.bends[x_b / kLanes] | std::uint64_t{b.bends[x_b / kLanes + 1]}
                                                           << kLanes;
    bits &= static_cast<std::uint32_t>(both >> (x_b % kLanes));
    if (bits == 0) return 0;
    const auto load = [](const std::vector<float>& row, std::size_t at) {
        return FloatV(row.data() + at, stdx::element_aligned);
    };
    const auto t = [&](const CrestRow& row, std::size_t at) {
        return LanesOfVec(load(row.direction[0], at), load(row.direction[1], at),
                          load(row.direction[2], at));
    };
    const FloatV turn = t(a, x).dot(t(b, x_b)), rise_a = load(a.rise, x),
                 rise_b = load(b.rise, x_b);
    const auto same = (rise_a > 0.0f) == (select<FloatV>(turn < 0.0f, -rise_b, rise_b) > 0.0f);
    return bits & static_cast<std::uint32_t>(lane_bits(stdx::abs(turn) > kLeastTurn && !same));
}

/// A crest line between two neighbours where the sign changes; what each row knows of its own.
std::optional<EdgeHit> crest(const Family& f, std::size_t a, float ea, const Vec3f& ta,
                             std::size_t b, float rise_b, const Vec3f& across) {
    const float sign = std::copysign(1.0f, dot(ta, across)), eb = rise_b * sign;
    const Vec3f tb = across * sign, d = f.s.point(b) - f.s.point(a);
    // k rises from both sides towards a ridge. An edge that runs along it cannot tell; its
    // neighbours can.
    const float along = dot(ta + tb, d);
    const bool tells = along * along > 0.36f * sq_length(d);
    if (tells && !(ea * along > 0)) return std::nullopt;
    const float at = ea / (ea - eb), k = f.k(a) * (1 - at) + f.k(b) * at;
    return EdgeHit{at, k, 0};
}

/// Rows [begin, end) of one family's crossings. v = e t, which does not change with the sign of t,
/// is averaged over some pixels of a sheet: within one cubic surfel e falls along t as on a
/// parabola (by 3 k^3, its fourth derivative is not there) and jumps back to the next: the average
/// takes the saw's teeth out of the lines.
void search_band(const Family& f, const Sheets& sheets, RowCrossings& rows, std::size_t begin,
                 std::size_t end) {
    const std::size_t width = sheets.width;
    CrestRow above(width), own(width);
    const auto bits_of = [&](const BitRows& bits, std::size_t y, std::size_t x) {
        return bits.at(static_cast<std::ptrdiff_t>(y), static_cast<std::ptrdiff_t>(x));
    };
    // at row y, `above`, and at what leads to the next, `own`
    const auto look = [&](std::size_t y) {
        const auto to = [&](bool down) {
            return [&, down](std::size_t x) {
                const SheetEdges& edges = sheets.to(down);
                const std::uint32_t joined = bits_of(edges.joined, y, x),
                                    creased = bits_of(edges.creased, y, x);
                const std::uint32_t change =
                    joined == 0 ? 0 : sign_changes(above, x, down ? own : above, down ? x : x + 1);
                return creased | (joined & change);
            };
        };
        rows.look(y, to(false), to(true), [&](std::size_t a, std::size_t b) {
            const bool down = b != a + 1;
            const std::size_t x = a - y * width, x_b = down ? x : x + 1;
            if (bits_of(sheets.to(down).creased, y, x) & 1) return crease(f, a, b);
            const CrestRow& other = down ? own : above;
            return crest(f, a, above.rise[x], above.t(x), b, other.rise[x_b], other.t(x_b));
        });
    };
    RowBlur<3> blur(sheets);
    const std::size_t last = std::min(end, sheets.height - 1);
    blur.run(
        begin, last + 1,
        [&](std::size_t y, std::size_t x) {
            const std::size_t i = y * width + x;
            const LanesOfVec v = f.directions(i) * f.rates(i);
            return std::array<FloatV, 3>{v.x, v.y, v.z};
        },
        [&](std::size_t y, const auto& mean) {
            std::swap(above, own);
            own.fill(f, sheets, y, mean);
            if (y > begin) look(y - 1);
        });
    if (last < end) std::swap(above, own), look(last);
}

}  // namespace

CrestLook crest_look(const LineScene& s, const Crossing& c, bool ridges) {
    const Family family{s, ridges};
    return {s.normal(c.pixel), c.evidence > 0 ? Vec3f{} : family.direction(c.pixel)};
}

CrossingField crest_crossings(const LineScene& s, const Sheets& sheets, bool ridges) {
    const Family family{s, ridges};
    return search_rows(s, blur_band(sheets),
                       [&](RowCrossings& rows, std::size_t begin, std::size_t end) {
                           search_band(family, sheets, rows, begin, end);
                       });
}

}  // namespace slim
