#include "pipeline/render/render_view.h"

#include "raytrace/scale_bar.h"
#include "slim/base/error.h"
#include "slim/base/nearest_name.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

namespace slim {
namespace {

constexpr int kLargestSide = 32768;

Camera camera_of_numbers(const std::vector<double>& n, const RenderConfig& config,
                         const Vec3d& origin) {
    Camera camera;
    camera.eye = Vec3d{n[0], n[1], n[2]} - origin;
    camera.target = Vec3d{n[3], n[4], n[5]} - origin;
    if (n.size() == 9) camera.up = {n[6], n[7], n[8]};
    else
        camera.up = up_vector(up_axis(config));
    camera.fov_y_deg = config.fov;
    camera.orthographic = config.ortho;
    // Without a width of its own: what a perspective view sees at the target.
    const double half = std::tan(config.fov * std::numbers::pi / 360);
    camera.width = 2 * half * length(camera.target - camera.eye);
    return camera;
}

Background solid(const Vec3f& color) { return {color, color, 1}; }

Background gradient() { return {*parse_color("#eef0f2"), *parse_color("#b4b9c1"), 1}; }

/// A path's pictures have the legend where the first has it: at the right. At one scale for all
/// sides a corner that is free of one's own may not be.
LegendRoom kept_room(const RenderConfig& config, const PictureSize& size, const LegendRoom& room) {
    if (config.ortho_width > 0) return {};
    if (!config.path.empty()) return LegendRoom::strip_at_right(room.right);
    LegendRoom kept = room;
    if (config.same_scale) kept.corner_width = 0;
    else if (config.scale_bar) {
        kept.bar_width =
            static_cast<double>(scale_bar_most(size.width, size.height)) / size.width;
        kept.bar_height = scale_bar_share(size.width, size.height);
    }
    return kept;
}

std::string text_of(const Vec3d& v) {
    return fmt::format("{:.17g},{:.17g},{:.17g}", v.x, v.y, v.z);
}

}  // namespace

std::vector<double> parse_numbers(const std::string& text) {
    std::vector<double> numbers;
    const char* at = text.data();
    const char* const end = at + text.size();
    while (at < end) {
        while (at < end && *at == ' ') ++at;
        double value = 0;
        const auto [rest, error] = std::from_chars(at, end, value);
        if (error != std::errc() || (rest < end && *rest != ',')) return {};
        numbers.push_back(value);
        at = rest < end ? rest + 1 : rest;
    }
    return numbers;
}

std::optional<Vec3f> parse_color(std::string_view text) {
    if (text.empty() || text[0] != '#') return std::nullopt;
    std::string digits(text.substr(1));
    if (digits.size() == 3)  // #abc is #aabbcc
        digits = {digits[0], digits[0], digits[1], digits[1], digits[2], digits[2]};
    if (digits.size() != 6) return std::nullopt;
    std::uint32_t rgb = 0;
    const auto [rest, error] = std::from_chars(digits.data(), digits.data() + 6, rgb, 16);
    if (error != std::errc() || rest != digits.data() + 6) return std::nullopt;
    const auto linear = [&](int shift) {
        return linear_from_srgb(static_cast<float>(rgb >> shift & 255u) / 255.0f);
    };
    return Vec3f{linear(16), linear(8), linear(0)};
}

PictureSize parse_size(const std::string& text) {
    PictureSize size;
    const char* const end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, size.width);
    if (first.ec == std::errc() && first.ptr < end && *first.ptr == 'x') {
        const auto second = std::from_chars(first.ptr + 1, end, size.height);
        if (second.ec == std::errc() && second.ptr == end && size.width >= 1 && size.height >= 1 &&
            size.width <= kLargestSide && size.height <= kLargestSide)
            return size;
    }
    throw ConfigError({.key = "size",
                       .expected = fmt::format("WIDTHxHEIGHT, each 1 to {}", kLargestSide),
                       .found = "'" + text + "'"});
}

namespace {

/// The middle of what is seen stays where it is, beside a legend that is kept free.
Camera enlarged(Camera camera, const Vec3d& to_middle, double zoom) {
    camera.width /= zoom;
    const Vec3d aside = to_middle * (1 - 1 / zoom);
    camera.eye += aside, camera.target += aside;
    const double half = std::tan(camera.fov_y_deg * std::numbers::pi / 360);
    if (zoom != 1) camera.fov_y_deg = std::atan(half / zoom) * 360 / std::numbers::pi;
    return camera;
}

/// A named camera beside legends and scale bar. Room that the zoom fills is not kept: they then
/// stand where they hide the least of the view that there would be without them. Films keep it, and
/// sides that are to have one scale.
FramedCamera framed_near(const RenderConfig& config, const Framed& framed, double aspect,
                         const Framing& framing, const LegendRoom& room) {
    const auto with = [&](const LegendRoom& kept, double free_bottom) {
        Framing own = framing;
        own.free_bottom = free_bottom;
        return framed_beside(config.camera, framed, aspect, own, kept);
    };
    const FramedCamera chosen = with(room, framing.free_bottom);
    const bool stays = config.turntable > 0 || !config.path.empty() || config.same_scale;
    if (config.zoom <= 1 || stays || framed.box.empty()) return chosen;
    const auto near = [&](const FramedCamera& of) {
        return enlarged(of.camera, of.to_middle, config.zoom);
    };
    LegendRoom kept = room;
    if (!leaves_room(near(chosen), framed, aspect, room))
        kept.right = kept.bottom = kept.corner_width = kept.corner_height = 0;
    const auto clears_bar = [&](double free_bottom) {
        return leaves_bar_room(near(with(kept, free_bottom)), framed, aspect, room);
    };
    const bool keeps_strip = clears_bar(framing.free_bottom) && !clears_bar(0);
    return with(kept, keeps_strip ? framing.free_bottom : 0);
}

}  // namespace

Camera make_camera(const RenderConfig& config, const ModelHeader& model, const PictureSize& size,
                   const LegendRoom& room) {
    const double aspect = static_cast<double>(size.width) / size.height;
    const bool orthographic = config.ortho || config.ortho_width > 0;
    Camera camera;
    Vec3d to_middle;  // of what a named camera frames
    if (is_camera_name(config.camera)) {
        const Framing framing{.up = up_axis(config),
                              .orthographic = orthographic,
                              .fov_y_deg = config.fov,
                              .turns = config.turntable,
                              .free_bottom = config.scale_bar && config.ortho_width <= 0
                                                 ? scale_bar_share(size.width, size.height)
                                                 : 0};
        const Framed framed(model.bounds, model.hull);
        const LegendRoom kept = kept_room(config, size, room);
        const FramedCamera named = framed_near(config, framed, aspect, framing, kept);
        camera = named.camera, to_middle = named.to_middle;
        if (config.same_scale)
            for (const char* side : {"front", "right", "top"})  // the others are as wide as these
                camera.width = std::max(
                    camera.width, framed_beside(side, framed, aspect, framing, kept).camera.width);
    } else {
        const std::vector<double> numbers = parse_numbers(config.camera);
        if (numbers.size() != 9 && numbers.size() != 6)
            throw ConfigError({.key = "camera",
                               .expected = fmt::format(
                                   "{} or nine numbers ex,ey,ez,tx,ty,tz,ux,uy,uz (six: the up "
                                   "axis of --up)",
                                   fmt::join(camera_names(), ", ")),
                               .found = "'" + config.camera + "'",
                               .hint = config.camera.find("zoom") == std::string::npos
                                           ? did_you_mean(config.camera, camera_names())
                                           : "--zoom 2 enlarges"});
        camera = camera_of_numbers(numbers, config, model.origin);
        camera.orthographic = orthographic;
        camera.width *= aspect;
    }
    if (config.ortho_width > 0) {
        constexpr double kNarrowest = 1e-90;  // a picture's, however it is zoomed
        if (config.ortho_width < kNarrowest)
            throw ConfigError({.key = "ortho_width",
                               .expected = fmt::format("0, or {} and more", kNarrowest),
                               .found = fmt::format("{}", config.ortho_width)});
        camera.width = config.ortho_width;
    }
    camera = enlarged(camera, to_middle, config.zoom);
    validate(camera);
    return camera;
}

UpAxis up_axis(const RenderConfig& config) {
    const char letter = config.up.back();
    if (config.up.size() == 1)
        return letter == 'x' ? UpAxis::x : letter == 'z' ? UpAxis::z : UpAxis::y;
    return letter == 'x' ? UpAxis::minus_x : letter == 'z' ? UpAxis::minus_z : UpAxis::minus_y;
}

std::string view_name(const RenderConfig& config) {
    if (!config.name.empty()) return config.name;
    return is_camera_name(config.camera) ? config.camera : "view";
}

bool is_folder_output(const std::filesystem::path& output) {
    return std::filesystem::is_directory(output) || !output.has_filename() ||
           !output.has_extension();
}

void check_view_name(const std::string& name) {
    if (name.find('/') != std::string::npos)
        throw ConfigError({.key = "name",
                           .expected = "a name without '/', which begins those of the pictures in "
                                       "the output folder",
                           .found = "'" + name + "'"});
}

std::string describe(const Camera& camera, const Vec3d& origin) {
    const std::string lens =
        camera.orthographic ? fmt::format("orthographic, width {:.17g}", camera.width)
                            : fmt::format("perspective, fov {:.17g} degrees", camera.fov_y_deg);
    return fmt::format("eye {} target {} up {} ({})", text_of(camera.eye + origin),
                       text_of(camera.target + origin), text_of(camera.up), lens);
}

ShadeView shade_view(const Camera& camera, const PictureSize& size, int first_x, int first_y) {
    const PixelView p = pixel_view(camera, size.width, size.height);
    const double px_per_unit = p.orthographic ? p.px_per_unit : p.focal_px;
    return {p.right,
            -p.down,
            -p.forward,
            size.width / (2 * px_per_unit),
            size.height / (2 * px_per_unit),
            p.orthographic,
            first_x,
            first_y,
            size.width,
            size.height};
}

namespace {

const std::vector<std::string> kBackgrounds{"auto", "white", "black", "gradient", "transparent"};

}  // namespace

Background parse_background(const std::string& text, bool is_map) {
    if (text == "auto") return is_map ? solid({1, 1, 1}) : gradient();
    if (text == "white") return solid({1, 1, 1});
    if (text == "black") return solid({0, 0, 0});
    if (text == "gradient") return gradient();
    if (text == "transparent") return {{}, {}, 0};
    const std::size_t comma = text.find(',');
    const auto top = parse_color(std::string_view(text).substr(0, comma));
    const auto bottom =
        comma == std::string::npos ? top : parse_color(std::string_view(text).substr(comma + 1));
    if (top && bottom) return {*top, *bottom, 1};
    throw ConfigError(
        {.key = "background",
         .expected = fmt::format("{}, #rrggbb or #rrggbb,#rrggbb (top, bottom)",
                                 fmt::join(kBackgrounds, ", ")),
         .found = "'" + text + "'",
         .hint = did_you_mean(text, kBackgrounds)});
}

}  // namespace slim
