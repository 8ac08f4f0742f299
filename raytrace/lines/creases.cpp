#include "raytrace/lines/creases.h"

#include "raytrace/lines/crease_choice.h"
#include "raytrace/lines/select.h"
#include "slim/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace slim {
namespace {

constexpr double kLongestStep = 1;  // pixels
constexpr int kMostHalvings = 24;
constexpr float kSameFace = 0.5f;

/// A place of an edge as the view sees it.
struct Place {
    Vec3d point, camera;
    double x = 0, y = 0;
    std::array<Vec3f, 2> normal;
    bool before_near = false;
};

/// The cubic from one point of an edge to the next: Hermite's, with the chord's length.
struct Piece {
    const EdgePoint &a, &b;
    double chord;
    Piece(const EdgePoint& from, const EdgePoint& to)
        : a(from), b(to), chord(length(to.point - from.point)) {}
    Vec3d at(double u) const {
        const double v = 1 - u;
        return a.point * (v * v * (1 + 2 * u)) + b.point * (u * u * (1 + 2 * v)) +
               (to_double(a.tangent) * v - to_double(b.tangent) * u) * (u * v * chord);
    }
};

class EdgeView {
public:
    EdgeView(const LineScene& scene, LineKind kind)
        : s_(scene), kind_(kind), inwards_(kind == LineKind::convex_crease ? -1.0 : 1.0) {}

    /// Looks at those steps of an edge that lie in the scene's rows; is_seen: of all its steps,
    /// from the first band on.
    void look(const SharpEdge& edge, std::vector<std::uint8_t>& is_seen) {
        std::size_t k = 0;
        walk(edge, [&](const Place& p, bool inside) {
            if (k == is_seen.size()) is_seen.push_back(0);
            if (inside && is_in_rows(p))
                is_seen[k] = is_visible(p) && !runs_on(p, 0) && !runs_on(p, 1) ? 1 : 0;
            ++k;
        });
    }

    /// The visible runs of one edge.
    std::vector<FeatureLine> lines(const SharpEdge& edge,
                                   const std::vector<std::uint8_t>& is_seen) {
        seen_.clear();
        is_seen_ = is_seen;
        walk(edge, [&](const Place& p, bool) { put(p); });
        close_gaps();
        return runs(edge.closed);
    }

private:
    Place place(const Piece& piece, double u) const {
        Place p;
        p.point = piece.at(u);
        p.camera = s_.view.camera_from_local(p.point);
        p.before_near = !s_.view.orthographic && !(p.camera.z > s_.view.near_plane);
        const double scale =
            s_.view.orthographic ? s_.view.px_per_unit : s_.view.focal_px / p.camera.z;
        p.x = s_.view.center_x + scale * p.camera.x, p.y = s_.view.center_y + scale * p.camera.y;
        const auto v = static_cast<float>(u);
        for (std::size_t k = 0; k < 2; ++k)
            p.normal[k] = piece.a.normal[k] * (1 - v) + piece.b.normal[k] * v;
        return p;
    }

    /// Whether nothing between two places of a piece can be in the picture.
    bool is_outside(const Place& a, const Place& b) const {
        if (a.before_near || b.before_near) return a.before_near && b.before_near;
        const double bulge = 1 + std::abs(a.x - b.x) + std::abs(a.y - b.y);
        return std::max(a.x, b.x) < -bulge || std::min(a.x, b.x) > s_.buffer.width + bulge ||
               std::max(a.y, b.y) < -bulge || std::min(a.y, b.y) > s_.picture_height() + bulge;
    }

    /// Calls visit(place, whether it can be in the picture) for the steps of an edge,
    /// in their order.
    template <class Visit>
    void walk(const SharpEdge& edge, Visit&& visit) const {
        const std::size_t n = edge.points.size();
        for (std::size_t i = 0; i + (edge.closed ? 0 : 1) < n; ++i) {
            const Piece piece(edge.points[i], edge.points[i + 1 == n ? 0 : i + 1]);
            const Place from = place(piece, 0), to = place(piece, 1);
            if (i == 0) visit(from, true);
            sample(piece, 0, from, 1, to, kMostHalvings, visit);
        }
    }

    /// Visits what follows `from` up to `to`, in steps of a pixel at most.
    template <class Visit>
    void sample(const Piece& piece, double u, const Place& from, double v, const Place& to,
                int halvings, Visit&& visit) const {
        if (is_outside(from, to)) return visit(to, false);
        const bool near = !from.before_near && !to.before_near &&
                          std::hypot(to.x - from.x, to.y - from.y) <= kLongestStep;
        if (near || halvings == 0) return visit(to, true);
        const double middle = 0.5 * (u + v);
        const Place half = place(piece, middle);
        sample(piece, u, from, middle, half, halvings - 1, visit);
        sample(piece, middle, half, v, to, halvings - 1, visit);
    }

    void put(const Place& p) {
        const std::array<Vec3f, 2> n{normalized(p.normal[0]), normalized(p.normal[1])};
        const float turn = EdgePoint{p.point, {}, n}.turn_deg();
        const Vec3f to_eye =
            to_float(s_.view.orthographic ? -s_.view.forward : normalized(s_.view.eye - p.point));
        seen_.push_back({static_cast<float>(p.x), static_cast<float>(p.y), to_float(p.point), 0,
                         turn, std::min(dot(n[0], to_eye), dot(n[1], to_eye))});
    }

    /// Whether a place is looked at in this band: each in one.
    bool is_in_rows(const Place& p) const {
        const double row = p.y - s_.rows.top;
        return row >= static_cast<double>(s_.first_row()) &&
               row < static_cast<double>(s_.end_row());
    }
    bool is_in_picture(double x, double y) const {
        return x >= 0 && y >= 0 && x < s_.buffer.width && y < s_.picture_height();
    }
    /// Entry of the planes at a pixel of the picture; the margin of a band has what is near its
    /// rows.
    std::size_t entry(int x, int y) const { return s_.buffer.index(x, y - s_.rows.top); }

    /// What a pixel says of a place: it shows one of its faces, something before it, or neither.
    enum class Says { shows, hides, nothing };
    Says ask(const Place& p, int x, int y) const {
        if (!is_in_picture(x, y)) return Says::nothing;
        const std::size_t i = entry(x, y);
        if (!s_.hit(i)) return Says::nothing;
        const Vec3f q = s_.point(i), n = s_.normal(i), d = to_float(p.point) - q;
        const float width = s_.footprint(i);
        const bool face = std::max(dot(n, p.normal[0]), dot(n, p.normal[1])) > kSameFace;
        if (face && std::fabs(dot(n, d)) <= kSheetGap * width &&
            sq_length(d) <= kReach * kReach * width * width)
            return Says::shows;
        return dot(to_float(s_.view.forward), d) > 0 ? Says::hides : Says::nothing;
    }

    /// Of the four pixels about the place one must show it; where they are all silent (a sliver of
    /// a face at the limb), one of the twelve about them.
    bool is_visible(const Place& p) const {
        if (p.before_near || !is_in_picture(p.x, p.y)) return false;
        const int x = static_cast<int>(std::floor(p.x - 0.5)),
                  y = static_cast<int>(std::floor(p.y - 0.5));
        bool hidden = false;
        for (const int k : {0, 1, 2, 3}) {
            const Says says = ask(p, x + (k & 1), y + (k >> 1));
            if (says == Says::shows) return true;
            hidden = hidden || says == Says::hides;
        }
        if (hidden) return false;
        for (int dy = -1; dy <= 2; ++dy)
            for (int dx = -1; dx <= 2; ++dx)
                if (ask(p, x + dx, y + dy) == Says::shows) return true;
        return false;
    }

    /// Whether the picture shows face k of the edge run on beyond it: the edge of a leaf that
    /// others cover, as beyond a corner that no leaf has.
    bool runs_on(const Place& p, std::size_t k) const {
        const Vec3d n = to_double(normalized(p.normal[k])),
                    other = to_double(normalized(p.normal[1 - k]));
        const Vec3d beyond = normalized(other - n * dot(n, other)) * -inwards_;
        const double width =
            s_.view.orthographic ? 1 / s_.view.px_per_unit : p.camera.z / s_.view.focal_px;
        const Vec3d moved = s_.view.camera_from_local(p.point + beyond * width);
        const double scale =
            s_.view.orthographic ? s_.view.px_per_unit : s_.view.focal_px / moved.z;
        const double dx = s_.view.center_x + scale * moved.x - p.x,
                     dy = s_.view.center_y + scale * moved.y - p.y;
        const double step = std::hypot(dx, dy);
        if (!(step > kEdgeOn)) return false;
        for (const double away : {1.5, 3.0}) {
            const double x = p.x + dx / step * away, y = p.y + dy / step * away;
            if (!is_in_picture(x, y)) return false;
            const std::size_t i = entry(static_cast<int>(x), static_cast<int>(y));
            if (!s_.hit(i)) return false;
            const Vec3d shown = to_double(s_.normal(i)), d = to_double(s_.point(i)) - p.point;
            const bool face = dot(shown, n) > dot(shown, other) && std::abs(dot(n, d)) < width;
            if (!face) return false;
        }
        return true;
    }

    /// Gaps of few pixels between seen places are single pixels that show something else.
    void close_gaps() {
        constexpr std::size_t kGap = 3;  // places
        std::size_t last = is_seen_.size();
        for (std::size_t i = 0; i < is_seen_.size(); ++i) {
            if (!is_seen_[i]) continue;
            if (last < i && i - last <= kGap + 1)
                std::fill(is_seen_.begin() + static_cast<std::ptrdiff_t>(last),
                          is_seen_.begin() + static_cast<std::ptrdiff_t>(i), std::uint8_t{1});
            last = i;
        }
    }

    std::vector<FeatureLine> runs(bool closed) {
        // A closed edge ends with its first place again.
        const bool whole = std::find(is_seen_.begin(), is_seen_.end(), 0) == is_seen_.end();
        if (closed) seen_.pop_back(), is_seen_.pop_back();
        if (closed && !whole) {  // begin where it is hidden, so that no run is cut in two
            const auto first = std::find(is_seen_.begin(), is_seen_.end(), 0) - is_seen_.begin();
            std::rotate(is_seen_.begin(), is_seen_.begin() + first, is_seen_.end());
            std::rotate(seen_.begin(), seen_.begin() + first, seen_.end());
        }
        std::vector<FeatureLine> out;
        for (std::size_t i = 0; i < seen_.size();) {
            if (!is_seen_[i]) {
                ++i;
                continue;
            }
            FeatureLine line;
            line.kind = kind_, line.closed = closed && whole;
            for (; i < seen_.size() && is_seen_[i]; ++i) line.points.push_back(seen_[i]);
            measure_line(line);
            if (line.points.size() > 1 && line.length_px >= kShortestRun)
                out.push_back(std::move(line));
        }
        return out;
    }

    static constexpr float kReach = 16;       // footprints, as the gap of a limb
    static constexpr float kShortestRun = 2;  // pixels
    static constexpr double kEdgeOn = 0.2;    // of a face's width, seen

    const LineScene& s_;
    LineKind kind_;
    double inwards_;  ///< a face lies on this side of the other's plane
    std::vector<LinePoint> seen_;
    std::vector<std::uint8_t> is_seen_;
};

}  // namespace

void CreaseSearch::add(const LineScene& scene) {
    const std::vector<std::uint8_t> chosen = chosen_edges(scene);
    constexpr std::size_t kGrain = 16;
    const std::size_t n = scene.edges.size();
    const bool is_last =
        scene.rows.top + static_cast<int>(scene.end_row()) == scene.picture_height();
    is_seen_.resize(n);
    std::vector<std::vector<FeatureLine>> of((n + kGrain - 1) / kGrain);
    parallel_blocks(n, kGrain, [&](std::size_t begin, std::size_t end) {
        EdgeView view(scene, kind_);
        for (std::size_t i = begin; i < end; ++i) {
            if (!chosen[i] || scene.edges[i].convex != (kind_ == LineKind::convex_crease)) continue;
            view.look(scene.edges[i], is_seen_[i]);
            if (!is_last) continue;
            auto lines = view.lines(scene.edges[i], is_seen_[i]);
            std::move(lines.begin(), lines.end(), std::back_inserter(of[begin / kGrain]));
        }
    });
    for (auto& lines : of) std::move(lines.begin(), lines.end(), std::back_inserter(lines_));
}

}  // namespace slim
