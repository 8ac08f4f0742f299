#include "pipeline/render/render_files.h"

#include "formats/extension.h"
#include "pipeline/input_kind.h"
#include "pipeline/manifest.h"
#include "pipeline/option_names.h"
#include "pipeline/render/render_directions.h"
#include "pipeline/shell_word.h"
#include "pipeline/version.h"
#include "raytrace/lines/stroke.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <iterator>
#include <map>
#include <system_error>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// True for an EXR, checked against --format.
bool wants_exr(const RenderConfig& config, const fs::path& output, bool folder) {
    if (folder) return config.format == "exr";
    const std::string extension = lower_extension(output);
    if (extension != ".png" && extension != ".exr")
        throw ConfigError({.key = "output",
                           .problem = " " + config.output,
                           .expected = ".png, .exr or a folder",
                           .found = output.extension().string()});
    if (config.format != "auto" && "." + config.format != extension)
        throw ConfigError(
            {.key = "output",
             .problem = " " + config.output + " contradicts " + quoted_key("format") + " " +
                        config.format});
    return extension == ".exr";
}

struct NamedPlane {
    const char* name;
    const std::vector<float>* values;
};

std::vector<NamedPlane> float_planes(const std::string& aov, const RenderedFrame& frame) {
    const GBuffer& b = frame.buffer;
    if (aov == "mean") return {{"curvature.mean", &b.mean}};
    if (aov == "gauss") return {{"curvature.gauss", &b.gauss}};
    if (aov == "k1") return {{"curvature.k1", &b.k1}};
    if (aov == "k2") return {{"curvature.k2", &b.k2}};
    if (aov == "e1") return {{"extremality.e1", &b.third[0]}};
    if (aov == "e2") return {{"extremality.e2", &b.third[3]}};
    if (aov == "dk1_dt2") return {{"extremality.dk1_dt2", &b.third[1]}};
    if (aov == "dk2_dt1") return {{"extremality.dk2_dt1", &b.third[2]}};
    if (aov == "dir1")
        return {
            {"dir1.X", &b.direction[0]}, {"dir1.Y", &b.direction[1]}, {"dir1.Z", &b.direction[2]}};
    if (aov == "normal")
        return {{"N.X", &b.normal[0]}, {"N.Y", &b.normal[1]}, {"N.Z", &b.normal[2]}};
    if (aov == "position")
        return {{"P.X", &b.position[0]}, {"P.Y", &b.position[1]}, {"P.Z", &b.position[2]}};
    if (aov == "depth") return {{"Z", &b.depth}};
    if (aov == "error") return {{"fit.error", &b.fit_error}};
    if (aov == "level") return {{"fit.level", &b.level}};
    if (aov == "coverage") return {{"fit.coverage", &b.coverage}};
    if (aov == "ao") return {{"light.ao", &frame.open}};
    if (aov == "truth_distance") return {{"truth.distance", &frame.truth_distance}};
    return {};
}

/// The colour planes of an interleaved picture: R G B A, or R G B of a layer.
void add_color(const Picture& picture, const std::string& layer,
               std::vector<std::vector<float>>& planes, std::vector<ExrChannel>& out) {
    const char* const names[] = {"R", "G", "B", "A"};
    for (std::size_t c = 0; c < (layer.empty() ? 4u : 3u); ++c) {
        std::vector<float> plane(picture.n_pixels());
        for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = picture.rgba[4 * i + c];
        planes.push_back(std::move(plane));
        out.push_back({layer + names[c], ChannelType::half_float, planes.back(), {}});
    }
}

/// 1 at hits: tells background from what is 0 in a file without a colour.
void add_hits(const GBuffer& buffer, std::vector<std::vector<float>>& planes,
              std::vector<ExrChannel>& out) {
    planes.emplace_back(buffer.hit.begin(), buffer.hit.end());
    out.push_back({"A", ChannelType::half_float, planes.back(), {}});
}

void add_second_direction(const GBuffer& buffer, std::vector<std::vector<float>>& planes,
                          std::vector<ExrChannel>& out) {
    const char* const names[] = {"dir2.X", "dir2.Y", "dir2.Z"};
    auto axes = second_directions(buffer);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        planes.push_back(std::move(axes[axis]));
        out.push_back({names[axis], ChannelType::float32, planes.back(), {}});
    }
}

/// Strength planes of the kinds asked for; lines.crest is ridges and valleys together.
void add_lines(const DrawnLines& drawn, std::vector<std::vector<float>>& planes,
               std::vector<ExrChannel>& out) {
    const auto add = [&](const char* name, std::vector<LineKind> of) {
        planes.push_back(
            strength_plane(drawn.lines, of, drawn.size.width, drawn.size.height, drawn.window));
        out.push_back({name, ChannelType::float32, planes.back(), {}});
    };
    for (const LineKind kind : drawn.kinds) switch (kind) {
            case LineKind::ridge:
                add("lines.crest", {LineKind::ridge, LineKind::valley});
                add("lines.ridge", {kind});
                break;
            case LineKind::valley: add("lines.valley", {kind}); break;
            case LineKind::suggestive: add("lines.suggestive", {kind}); break;
            case LineKind::contour: add("marks.contour", {kind}); break;
            case LineKind::parabolic: add("marks.parabolic", {kind}); break;
            case LineKind::reflection: add("marks.reflection", {kind}); break;
            case LineKind::convex_crease: add("creases.convex", {kind}); break;
            case LineKind::concave_crease: add("creases.concave", {kind}); break;
        }
}

std::string source_date() {
    const char* text = std::getenv("SOURCE_DATE_EPOCH");
    if (!text || !*text) return "";
    std::time_t seconds = 0;
    const auto [rest, error] = std::from_chars(text, text + std::strlen(text), seconds);
    std::tm utc{};
    if (error != std::errc() || *rest != 0 || !gmtime_r(&seconds, &utc))
        throw ConfigError(std::string("SOURCE_DATE_EPOCH=") + text +
                          ": expected seconds since 1970");
    char date[32];
    std::strftime(date, sizeof date, "%Y:%m:%d %H:%M:%S", &utc);
    return date;
}

/// Of the model; 0: the unit or the scale is not known, or it is no number of a print.
double pixels_per_metre(const RenderConfig& config, const Camera& camera,
                        const PictureSize& size) {
    static const std::map<std::string, double> kMetres = {
        {"mm", 1e-3}, {"cm", 1e-2}, {"dm", 0.1},    {"m", 1},
        {"km", 1e3},  {"in", 0.0254}, {"ft", 0.3048}};
    const auto unit = kMetres.find(config.unit);
    if (!camera.orthographic || unit == kMetres.end()) return 0;
    const double n = size.width / (camera.width * unit->second);
    constexpr double kLeast = 100, kMost = 1e6;
    return n >= kLeast && n <= kMost ? n : 0;
}

std::array<float, 16> rows(const double (&m)[4][4]) {
    std::array<float, 16> out;
    for (std::size_t i = 0; i < 16; ++i) out[i] = static_cast<float>(m[i / 4][i % 4]);
    return out;
}

}  // namespace

fs::path OutputPlan::legend(const std::string& aov) const {
    const bool has_aov = stem.extension() == "." + aov;  // x.mean of x.mean.png
    return fs::path(stem.string() + (has_aov ? "" : "." + aov) + ".legend.svg");
}

std::string OutputPlan::drawing_stem() const {
    const bool has_aov = drawn.size() == 1 && stem.extension() == "." + drawn[0];
    return (has_aov ? fs::path(stem).replace_extension() : stem).string() + number;
}

fs::path OutputPlan::lines_svg() const { return drawing_stem() + ".lines.svg"; }

fs::path OutputPlan::contours_svg() const { return drawing_stem() + ".contours.svg"; }

OutputPlan OutputPlan::numbered(int k) const {
    OutputPlan out = *this;
    out.number = fmt::format("_{:04}", k);
    const auto with_number = [&](fs::path file) {
        const std::string extension = file.extension().string();
        return file.replace_extension().string() + out.number + extension;
    };
    for (fs::path& png : out.pngs) png = with_number(png);
    if (!exr.empty()) out.exr = with_number(exr);
    return out;
}

std::vector<std::string> film_commands(const OutputPlan& plan) {
    std::vector<std::string> commands;
    for (const fs::path& png : plan.pngs) {
        fs::path stem = png;
        stem.replace_extension();
        // Encoders want even sides.
        commands.push_back(
            fmt::format("ffmpeg -framerate 24 -i {} -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' "
                        "-c:v libx264 -pix_fmt yuv420p {}",
                        shell_quoted(stem.string() + "_%04d" + png.extension().string()),
                        shell_quoted(stem.string() + ".mp4")));
    }
    return commands;
}

OutputPlan plan_outputs(const RenderConfig& config, const std::vector<std::string>& aovs) {
    const fs::path output = config.output;
    const bool folder = is_folder_output(output);
    const bool exr = wants_exr(config, output, folder);
    OutputPlan plan;
    plan.stem = folder ? output / view_name(config) : fs::path(output).replace_extension();
    const std::string stem = plan.stem.string();
    const std::string extension = !folder ? output.extension().string() : exr ? ".exr" : ".png";
    plan.named = stem + extension;
    if (exr) {
        plan.exr = plan.named;
        plan.drawn = {aovs.front()};
        plan.pngs = {stem + ".png"};
        return plan;
    }
    plan.drawn = aovs;
    for (const std::string& aov : aovs)
        plan.pngs.push_back(stem + (folder || aovs.size() > 1 ? "." + aov : "") + extension);
    return plan;
}

void make_folder(const OutputPlan& plan) {
    const fs::path folder = plan.stem.parent_path();
    if (!folder.empty()) make_writable_folder(folder);
}

std::vector<ExrChannel> exr_channels(const std::vector<std::string>& aovs,
                                     const RenderedFrame& frame, std::span<const ColorPlane> colors,
                                     const DrawnLines& lines,
                                     std::vector<std::vector<float>>& planes) {
    std::vector<ExrChannel> out;
    // The channels look at the planes' values, which moving a vector keeps.
    planes.reserve(4 * colors.size() + 1 + 3 + lines.kinds.size() + 1);
    for (const ColorPlane& color : colors)
        add_color(color.picture, out.empty() ? "" : color.aov + ".", planes, out);
    if (colors.empty()) add_hits(frame.buffer, planes, out);
    for (const std::string& aov : aovs) {
        if (aov == "dir2") add_second_direction(frame.buffer, planes, out);
        if (aov == "id")
            out.push_back({"surfel.id", ChannelType::uint32, {}, frame.buffer.surfel_id});
        for (const NamedPlane& plane : float_planes(aov, frame))
            out.push_back({plane.name, ChannelType::float32, *plane.values, {}});
    }
    add_lines(lines, planes, out);
    return out;
}

ImageMetadata make_metadata(const RenderConfig& config, const std::string& canonical_config,
                            const std::string& model_hash, const ModelHeader& model,
                            const Camera& camera, const PictureSize& size) {
    const Vec3d& o = model.origin;
    ImageMetadata metadata{
        {"Software", "slim " + program_version()},
        {"slim:config", canonical_config},
        {"slim:configHash", hash_text(canonical_config)},
        {"slim:tree", model_hash},
        {"slim:camera", describe(camera, o)},
        {"slim:origin", fmt::format("{:.17g} {:.17g} {:.17g}", o.x, o.y, o.z)},
        {"slim:units", config.unit.empty() ? "model units" : config.unit},
        {"slim:seed", std::to_string(model.seed)},
        {"slim:curvature", "positive where convex, normals outwards, 1/length"},
        {"slim:directions",
         "unit, sign arbitrary; t2 = N x t1; extremality goes with these signs, 1/length^2"},
    };
    if (const double n = pixels_per_metre(config, camera, size); n > 0)
        metadata[kPixelsPerMetre] = std::to_string(std::lround(n));
    // No renderTimeSeconds (CONVENTIONS 1.2): a clock would make every run's bytes its own. The
    // time is in the manifest.
    if (const std::string date = source_date(); !date.empty()) metadata["DateTime"] = date;
    return metadata;
}

SvgScale svg_scale(const RenderConfig& config, const Camera& camera, const PictureSize& size) {
    const double n = pixels_per_metre(config, camera, size);
    return n > 0 ? SvgScale(1000 / n) : SvgScale();
}

ImageMatrices make_matrices(const Camera& camera, const PictureSize& size) {
    const PixelView v = pixel_view(camera, size.width, size.height);
    const Vec3d axes[3] = {v.right, -v.down, -v.forward};
    double to_camera[4][4] = {}, to_ndc[4][4] = {};
    // Points are rows: each axis is a column, and the translation lies in the last row.
    for (int column = 0; column < 3; ++column) {
        for (int row = 0; row < 3; ++row)
            to_camera[row][column] = axes[column][static_cast<std::size_t>(row)];
        to_camera[3][column] = -dot(axes[column], v.eye);
    }
    to_camera[3][3] = 1;
    // x / w = s x / depth + 1/2 (perspective: w = depth = -z) or s x + 1/2 (orthographic: w = 1).
    const double scale = v.orthographic ? v.px_per_unit : v.focal_px;
    const double sx = scale / size.width, sy = -scale / size.height;
    double projection[4][4] = {{sx, 0, 0, 0}, {0, sy, 0, 0}, {0, 0, -1, 0}, {0, 0, 0, 0}};
    projection[v.orthographic ? 3 : 2][0] = v.orthographic ? 0.5 : -0.5;
    projection[v.orthographic ? 3 : 2][1] = v.orthographic ? 0.5 : -0.5;
    projection[v.orthographic ? 3 : 2][3] = v.orthographic ? 1 : -1;
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            for (int k = 0; k < 4; ++k)
                to_ndc[row][column] += to_camera[row][k] * projection[k][column];
    // Screen = 2 NDC - 1 along x, 1 - 2 NDC along y, with w as it is.
    double to_screen[4][4];
    for (int row = 0; row < 4; ++row) {
        const double(&ndc)[4] = to_ndc[row];
        const double screen[4] = {2 * ndc[0] - ndc[3], ndc[3] - 2 * ndc[1], ndc[2], ndc[3]};
        std::copy(std::begin(screen), std::end(screen), to_screen[row]);
    }
    return {{"worldToCamera", rows(to_camera)},
            {"worldToNDC", rows(to_ndc)},
            {"worldToScreen", rows(to_screen)}};
}

}  // namespace slim
