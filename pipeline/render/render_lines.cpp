#include "pipeline/render/render_lines.h"

#include "formats/extension.h"
#include "pipeline/contains.h"
#include "pipeline/input_kind.h"
#include "pipeline/render/render_line_choice.h"
#include "pipeline/render/render_view.h"
#include "pipeline/stage.h"
#include "raytrace/lines/lines_geometry.h"
#include "raytrace/lines/lines_svg.h"
#include "raytrace/lines/one_stroke.h"
#include "raytrace/lines/select.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

namespace slim {
namespace {

/// What would give a model that has it, as whoever asked says that.
std::string of_a_build(const std::string& option, const std::string& key) {
    return runs_in_a_job() ? "expected " + key + " in [fit]" : "build it with " + option;
}

/// Why lines of that kind cannot be drawn from the model.
std::string what_lacks(LineKind kind, const std::string& name, int degree) {
    if (is_crease(kind))
        return fmt::format(
            "{}: crease lines are the edges between the sheets of sharp surfels, of which the "
            "model has none: {} (if it was, no edge was found)",
            name, of_a_build("--sharp on", "sharp = \"on\""));
    const int needed = line_degree(kind);
    return fmt::format("{}: {} lines need derivatives that a model of degree {} does not have: {}",
                       name, line_word(kind), degree,
                       of_a_build(fmt::format("--degree {}", needed),
                                  fmt::format("degree = {}", needed)));
}

/// What a file of lines must be named, so that it is no picture and no model.
void check_line_file(const std::string& path, const char* extension, const RenderConfig& config) {
    if (path.empty()) return;
    if (lower_extension(path) != extension)
        throw ConfigError(
            {.file = path, .expected = std::string("a name ending in ") + extension});
    refuse_to_overwrite(path, {config.model});
}

}  // namespace

void check_lines(const RenderConfig& config) {
    check_line_file(config.lines_ply, ".ply", config);
    check_line_file(config.lines_obj, ".obj", config);
}

std::vector<LineKind> wanted_lines(const RenderConfig& config, const std::vector<std::string>& aovs,
                                   const ModelHeader& model, bool sharp, Reporter& reporter) {
    const LineChoice choice = line_choice(config, aovs, model.degree, sharp);
    std::set<std::string> without;
    for (const LineKind kind : choice.lacking) {
        if (!without.insert(line_word(kind)).second) continue;
        const std::string why = what_lacks(kind, config.model, model.degree);
        if (choice.n_words == 1) throw ConfigError(why);
        // A job asks for them of any scan; of one without edges nothing is missing then.
        if (is_crease(kind) && runs_in_a_job())
            reporter.info(why + "; they are left out");
        else
            reporter.warn(why + "; they are left out");
    }
    if (choice.drawn.empty() && !choice.lacking.empty())
        throw ConfigError(
            fmt::format("{}: none of the lines asked for can be drawn from a model of degree "
                        "{}{}: {}",
                        config.model, model.degree,
                        without.contains("crease") ? " without sharp surfels" : "",
                        of_a_build("--degree 3", "degree = 3")));
    return choice.drawn;
}

namespace {

/// Lines that say where the surface ends or what it mirrors, not how it bends.
bool is_of_the_picture(LineKind kind) { return line_degree(kind) == 1 && !is_crease(kind); }

/// Shows the pixels of one model of several alone: the others count as background meanwhile.
class OneModel {
public:
    OneModel(std::size_t number, RenderedFrame& frame) : frame_(frame), all_(frame.buffer.hit) {
        std::vector<std::uint8_t>& hit = frame.buffer.hit;
        for (std::size_t i = 0; i < hit.size(); ++i)
            hit[i] = hit[i] && frame.traced.model[i] == number ? 1 : 0;
    }
    ~OneModel() { std::swap(frame_.buffer.hit, all_); }

private:
    RenderedFrame& frame_;
    std::vector<std::uint8_t> all_;
};

}  // namespace

PictureLines::PictureLines(std::span<const LineModel> models, std::span<const LineKind> kinds)
    : kinds_(kinds.begin(), kinds.end()) {
    const ModelHeader& first = *models[0].header;
    if (models.size() == 1) {
        searches_.push_back(
            {kAllModels, first.diagonal, first.degree, models[0].edges, LineSearch(kinds)});
        return;
    }
    std::vector<LineKind> whole, creases;
    std::copy_if(kinds.begin(), kinds.end(), std::back_inserter(whole), is_of_the_picture);
    std::copy_if(kinds.begin(), kinds.end(), std::back_inserter(creases), is_crease);
    double diagonal = 0;
    for (const LineModel& model : models) diagonal = std::max(diagonal, model.header->diagonal);
    searches_.push_back({kAllModels, diagonal, first.degree, {}, LineSearch(whole)});
    for (std::size_t m = 0; m < models.size(); ++m) {
        // The frame holds what the first one needs.
        const ModelHeader& model = *models[m].header;
        const int degree = std::min(first.degree, model.degree);
        std::vector<LineKind> own;
        std::copy_if(kinds.begin(), kinds.end(), std::back_inserter(own), [&](LineKind kind) {
            return line_degree(kind) > 1 && line_degree(kind) <= degree;
        });
        // The model's own crest lines give way to its creases, which are known before them.
        searches_.push_back(
            {kAllModels, model.diagonal, degree, models[m].edges, LineSearch(creases)});
        searches_.push_back({m, model.diagonal, degree, {}, LineSearch(own)});
    }
}

void PictureLines::add(int begin, int end, RenderedFrame& frame) {
    const SceneRows rows{frame.window.y, frame.size.height, begin, end};
    px_ = line_pixel(frame.buffer.width, frame.size.height);
    for (Search& search : searches_) {
        std::optional<OneModel> alone;
        if (search.model != kAllModels) alone.emplace(search.model, frame);
        search.lines.add(
            {frame.buffer, frame.pixels, search.diagonal, search.degree, search.edges, rows});
    }
}

std::vector<FeatureLine> PictureLines::finish() {
    std::vector<FeatureLine> lines, more;
    for (Search& search : searches_) {
        more = search.lines.finish(search.model == kAllModels ? std::vector<FeatureLine>{}
                                                              : std::move(more));
        lines.insert(lines.end(), more.begin(), more.end());
    }
    const auto rank = [&](const FeatureLine& line) {
        return std::find(kinds_.begin(), kinds_.end(), line.kind);
    };
    std::stable_sort(lines.begin(), lines.end(),
                     [&](const FeatureLine& a, const FeatureLine& b) { return rank(a) < rank(b); });
    // The search for one model's has done so.
    return searches_.size() > 1 ? one_stroke(std::move(lines), px_) : lines;
}

std::vector<NamedText> line_files(const RenderConfig& config, const std::filesystem::path& svg,
                                  const SvgScale& scale, const Vec3d& origin,
                                  const DrawnLines& drawn) {
    std::vector<NamedText> files{
        {svg, lines_svg(drawn.lines, drawn.kinds, drawn.size.width, drawn.size.height, drawn.window,
                        parse_background(config.background, true), scale)}};
    if (!config.lines_ply.empty())
        files.push_back({config.lines_ply, lines_ply(drawn.lines, origin)});
    if (!config.lines_obj.empty())
        files.push_back({config.lines_obj, lines_obj(drawn.lines, origin)});
    return files;
}

nlohmann::json lines_json(std::span<const FeatureLine> lines, std::span<const LineKind> kinds) {
    nlohmann::json out = nlohmann::json::object();
    for (const LineKind kind : kinds) {
        std::uint64_t polylines = 0;
        double length = 0, length_px = 0, strength = 0;
        for (const FeatureLine& line : lines) {
            if (line.kind != kind) continue;
            ++polylines;
            length += static_cast<double>(line.length);
            length_px += static_cast<double>(line.length_px);
            strength += static_cast<double>(is_crease(kind) ? line.strength * line.length_px
                                                            : line.strength);
        }
        if (is_crease(kind) && length_px > 0) strength /= length_px;
        out[std::string(line_name(kind))] = {{"polylines", polylines},
                                             {"length", length},
                                             {"length_px", length_px},
                                             {"strength", strength}};
    }
    return out;
}

}  // namespace slim
