#include "pipeline/render/render_look.h"

#include "pipeline/config.h"
#include "pipeline/render/render_directions.h"
#include "pipeline/render/render_maps.h"
#include "pipeline/render/render_uses.h"
#include "raytrace/scale_bar.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace slim {
namespace {

Legend level_legend(const ColorMap& map, const ValueRange& range) {
    return {"level", "1: coarsest", &map, range, "", ""};
}

AovLook look_of_levels(const GBuffer& b) {
    const ValueRange levels = full_range(b.level, b.hit);
    const double lo = std::round(levels.lo);
    // At least five steps, so that the legend's ticks are whole numbers.
    const int n = std::max(5, static_cast<int>(std::round(levels.hi) - lo) + 1);
    AovLook look;
    look.own_map = std::make_shared<const ColorMap>(stepped_viridis(n));
    look.legend = level_legend(*look.own_map, {lo - 0.5, lo + n - 0.5});
    return look;
}

/// What of the lines is there.
Key contour_key(const RenderConfig& config, const ContourLevels& contours) {
    const std::string unit = config.unit.empty() ? "units" : config.unit;
    Key key{"contour lines", {{fmt::format("every {:g} {}", contours.spacing, unit), false, {}}}};
    if (contours.heavy > 0)
        key.rows.push_back(
            {fmt::format("heavy every {:g} {}", contours.heavy_spacing, unit), false, {}});
    return key;
}

/// The reference's hits, as an object over transparent.
Picture silhouette_of(const GBuffer& b) {
    Picture out(b.width, b.height);
    for (std::size_t i = 0; i < b.n_pixels(); ++i) out.rgba[4 * i + 3] = b.hit[i];
    return out;
}

/// A legend before anything is drawn: its words are known, its numbers are of a usual length.
std::optional<Legend> expected_legend(const RenderConfig& config, const std::string& aov) {
    constexpr ValueRange kUsual{-2500, 2500};
    if (aov == "level") return level_legend(viridis(), kUsual);
    if (!map_spec(aov)) return std::nullopt;
    Legend legend = make_legend(config, aov, kUsual, {}, {});
    legend.clipped_high = legend.clipped_low = true;
    return legend;
}

/// The same of a key.
std::optional<Key> expected_key(const RenderConfig& config, const std::string& aov) {
    if (aov == "dir1" || aov == "dir2") return direction_key(aov == "dir2");
    if (aov != "hillshade" || config.contours == "none") return std::nullopt;
    ContourLevels usual;
    usual.spacing = 2500, usual.heavy_spacing = 12500, usual.lines = usual.heavy = 1;
    return contour_key(config, usual);
}

/// The largest of several legends and keys.
class RoomOfWords {
public:
    RoomOfWords(const RenderConfig& config, const PictureSize& size) : size_(size) {
        if (!config.scale_bar) return;
        above_ = static_cast<float>(scale_bar_share(size.width, size.height) * size.height);
        if (above_ > 0) beside_ = scale_bar_most(size.width, size.height);
    }

    void add(const Legend& legend) {
        const double share = legend_share(legend, size_.width, size_.height);
        const PixelBox top =
            legend_box(legend, LegendPlace::right_top, size_.width, size_.height);
        if (share <= 0 || meets_bar(top)) return;
        add(share, legend_box(legend, LegendPlace::right_bottom, size_.width, size_.height),
            legend_box(legend, LegendPlace::below, size_.width, size_.height));
    }
    void add(const Key& key) {
        const double share = key_share(key, size_.width, size_.height);
        const PixelBox top = key_box(key, LegendPlace::right_top, size_.width, size_.height);
        if (share <= 0 || meets_bar(top)) return;
        const PixelBox box = key_box(key, LegendPlace::right_bottom, size_.width, size_.height);
        add(share, box, box);
    }
    LegendRoom room() const {
        LegendRoom room = room_;
        if (!fits_below_) room.bottom = 0;
        return room;
    }

private:
    /// Of words in the corner that is farthest from a scale bar at the lower left.
    bool meets_bar(const PixelBox& top) const {
        return top.x0 < beside_ && top.y1 > static_cast<float>(size_.height) - above_;
    }
    void add(double share, const PixelBox& corner, const PixelBox& below) {
        const auto width_of = [&](float x0) { return 1 - static_cast<double>(x0) / size_.width; };
        const auto height_of = [&](float y0) { return 1 - static_cast<double>(y0) / size_.height; };
        room_.right = std::max(room_.right, share);
        room_.corner_width = std::max(room_.corner_width, width_of(corner.x0));
        room_.corner_height = std::max(room_.corner_height, height_of(corner.y0));
        room_.bottom = std::max(room_.bottom, height_of(below.y0));
        fits_below_ = fits_below_ && below.x0 > beside_ && below.y0 > 0;
    }

    PictureSize size_;
    LegendRoom room_;
    bool fits_below_ = true;
    float beside_ = 0;  ///< where a scale bar ends
    float above_ = 0;   ///< its height, with the margin
};

/// Whether the lower left corner may not be free for the scale bar. Films keep it there.
bool moves_scale_bar(const RenderConfig& config) {
    const bool is_framed =
        is_camera_name(config.camera) && config.zoom <= 1 && config.ortho_width <= 0;
    const bool is_film = config.turntable > 0 || !config.path.empty();
    return config.scale_bar && !is_framed && !is_film;
}

/// What a legend or key at its best place hides of an object and of a scale bar.
struct WordsPlace {
    LegendPlace place = LegendPlace::right;
    double hidden = 0;
    bool over_bar = false;
};
WordsPlace place_of_words(const RenderConfig& config, const AovLook& look, const Picture& object,
                          const PixelBox& taken) {
    if (!config.legend || !look.on_white()) return {};
    const auto box_of = [&](LegendPlace place) {
        return look.key ? key_box(*look.key, place, object.width, object.height)
                        : legend_box(*look.legend, place, object.width, object.height);
    };
    const LegendPlace place = look.key ? best_key_place(*look.key, object, taken)
                                       : best_legend_place(*look.legend, object, taken);
    const PixelBox box = box_of(place);
    return {place, hidden_by(box, object, taken), shared_area(box, taken) > 0};
}

/// Whether a small picture has no room for words beside its scale bar: they would stand over it, or
/// over much of what the camera frames.
bool lack_room(const RenderConfig& config, const WordsPlace& words, const Picture& object) {
    constexpr double kMuch = 0.2;
    if (!config.scale_bar || words.over_bar) return words.over_bar;
    const PixelBox all{0, 0, static_cast<float>(object.width), static_cast<float>(object.height)};
    return !moves_scale_bar(config) && words.hidden > kMuch * covered_alpha(all, object);
}

/// Legend and scale bar stand where both together hide the least; the bar at the lower left if no
/// other corner is better. Without room for both the bar stays.
void place_all(const RenderConfig& config, const RenderedFrame& frame, AovLook& look) {
    constexpr std::array kCorners{LegendPlace::left_bottom, LegendPlace::right_bottom,
                                  LegendPlace::left_top, LegendPlace::right_top};
    const std::span corners = std::span(kCorners).first(moves_scale_bar(config) ? 4 : 1);
    const Picture object = silhouette_of(frame.buffer);
    double least = std::numeric_limits<double>::infinity();
    for (const LegendPlace corner : corners) {
        const PixelBox bar = config.scale_bar
                                 ? scale_bar_box({frame.pixels.px_per_unit, config.unit},
                                                 object.width, object.height, corner)
                                 : PixelBox{};
        const WordsPlace words = place_of_words(config, look, object, bar);
        const double hidden = words.hidden + covered_alpha(bar, object);
        if (hidden >= least) continue;
        least = hidden;
        look.place = words.place, look.bar_place = corner;
        look.words_fit = !lack_room(config, words, object);
    }
}

}  // namespace

AovLook look_of(const RenderConfig& config, const std::string& aov, const RenderedFrame& reference,
                const MapScale& scale, const ContourLevels& contours, const ValueRange* wider) {
    const GBuffer& b = reference.buffer;
    AovLook look;
    if (aov == "level") look = look_of_levels(b);
    if (map_spec(aov)) {
        const MapValues values = map_values(aov, reference);
        ValueRange range = map_range(config, aov, values.span(), b, scale);
        if (wider)
            range.lo = std::min(range.lo, wider->lo), range.hi = std::max(range.hi, wider->hi);
        look.legend = make_legend(config, aov, range, values.span(), b.hit);
    }
    if (aov == "dir1" || aov == "dir2") look.key = direction_key(aov == "dir2");
    if (aov == "hillshade" && contours.lines > 0) look.key = contour_key(config, contours);
    if (b.n_pixels() > 0) place_all(config, reference, look);
    return look;
}

ValueRange range_of(const RenderConfig& config, const std::string& aov,
                    const RenderedFrame& reference, const MapScale& scale) {
    const MapValues values = map_values(aov, reference);
    return map_range(config, aov, values.span(), reference.buffer, scale);
}

bool needs_reference(const RenderConfig& config, const std::string& aov) {
    return moves_scale_bar(config) || aov == "level" || map_spec(aov) || aov == "dir1" ||
           aov == "dir2" || (aov == "hillshade" && config.contours != "none");
}

LegendRoom legend_room(const RenderConfig& config, const std::vector<std::string>& drawn,
                       const PictureSize& size) {
    if (!config.legend_room && !has_legend(config, drawn)) return {};
    const auto room_of = [&](const std::vector<std::string>& aovs) {
        RoomOfWords room(config, size);
        for (const std::string& aov : aovs) {
            if (const auto legend = expected_legend(config, aov)) room.add(*legend);
            if (const auto key = expected_key(config, aov)) room.add(*key);
        }
        return room.room();
    };
    const LegendRoom own = room_of(drawn);
    if (!config.legend_room && (own.right <= 0 || legends_of(config, drawn) != Legends::maps))
        return own;
    RenderConfig any;
    const FieldList fields = fields_of(any);
    return room_of(fields.find("aov")->choices);
}

}  // namespace slim
