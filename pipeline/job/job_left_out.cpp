#include "pipeline/job/job_left_out.h"

#include "pipeline/config.h"
#include "pipeline/contains.h"
#include "pipeline/render/ray_options.h"
#include "pipeline/render/render_asked.h"
#include "pipeline/render/render_lights.h"
#include "pipeline/render/render_line_choice.h"
#include "slim/fit/edge_share.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace slim {
namespace {

/// Of the model that [fit] makes: "auto" has surfels of all degrees.
int model_degree(const BuildStages& stages) {
    return stages.degree == "1" ? 1 : stages.degree == "2" ? 2 : 3;
}

/// What one view has the renderer do.
struct ViewWork {
    std::vector<std::string> aovs;  ///< without "all"
    LineChoice lines;
    Channels channels = 0;
};

ViewWork work_of(const AskedView& view, const BuildStages& stages) {
    ViewWork work;
    const int degree = model_degree(stages);
    work.aovs = possible_aovs(view.aovs, degree, stages.color && view.render.add.empty());
    work.lines = line_choice(view.render, view.aovs, degree, stages.sharp != "off");
    work.channels =
        channels_of(work.aovs, view.render.light_maps) | line_channels(work.lines.drawn, degree);
    return work;
}

std::string fit_remedy(LineKind kind, const BuildStages& stages) {
    if (!is_crease(kind))
        return "they need " + model_remedy(stages, "degree", std::to_string(line_degree(kind)));
    if (stages.sharp == "auto")
        return "drawn if the points lie at edges enough for sharp surfels: sharp = \"on\" in [fit] "
               "has these always";
    return "they need sharp surfels: " + model_remedy(stages, "sharp", "on");
}

constexpr const char* kLeftToPoints = "sharp surfels: unless ";
constexpr const char* kPicturesOf = "pictures of ";

/// What the points will decide; empty if [fit] does.
std::string left_to_the_points(const std::string& sharp) {
    if (sharp != "auto") return "";
    return fmt::format(
        "{}the cloud is a mesh of large faces, or more than {:.1f} % of the "
        "places that the build looks at lie at edges (sharp = \"auto\" in [fit]; the build says)",
        kLeftToPoints, 100 * kEdgeShare);
}

/// Reasons in the order in which they came, each once, with the views that it is of.
class ReasonsOfViews {
public:
    void add(const std::string& view, const std::string& reason) {
        const auto known = std::find_if(reasons_.begin(), reasons_.end(),
                                        [&](const Reason& r) { return r.text == reason; });
        if (known == reasons_.end()) reasons_.push_back({reason, {view}});
        else if (known->views.back() != view) known->views.push_back(view);
    }
    /// "views front, iso: crest lines: ...".
    std::vector<std::string> lines() const {
        std::vector<std::string> out;
        for (const Reason& r : reasons_)
            out.push_back(fmt::format("view{} {}: {}", r.views.size() > 1 ? "s" : "",
                                      fmt::join(r.views, ", "), r.text));
        return out;
    }

private:
    struct Reason {
        std::string text;
        std::vector<std::string> views;
    };
    std::vector<Reason> reasons_;
};

}  // namespace

std::vector<std::string> left_out_of_views(std::span<const AskedView> views,
                                           const BuildStages& stages) {
    Channels channels = 0;
    std::set<std::string> aovs, asked;
    bool lines = false, rays = false, shadows = false, openness = false, colors = false;
    for (const AskedView& view : views) {
        const ViewWork work = work_of(view, stages);
        channels |= work.channels;
        aovs.insert(work.aovs.begin(), work.aovs.end());
        asked.insert(view.aovs.begin(), view.aovs.end());
        colors = colors || takes_colors(view.render, work.aovs);
        lines = lines || !work.lines.drawn.empty();
        const bool cast = view.render.mode == "raytrace", shaded = contains(work.aovs, "shaded");
        rays = rays || cast;
        shadows = shadows || (cast && view.render.shadows && shaded);
        openness = openness || view.render.ao || contains(work.aovs, "ao");
    }
    std::vector<std::string> out;
    if (!(channels & kHessianChannels))
        out.push_back("curvature: no AOV and no line asks for it (no second derivatives)");
    if (!(channels & kThirdOrderChannel))
        out.push_back("third derivatives: no AOV and no line that can be drawn asks for them");
    if (!lines) out.push_back("feature lines: no view asks for them");
    if (std::string text = left_to_the_points(stages.sharp); !text.empty())
        out.push_back(std::move(text));
    if (!colors)
        out.push_back(stages.color
                          ? "colours: no view shows them (their section of the model is not read)"
                      : stages.given
                          ? "colours: the model has none"
                          : "colours: color = false in [fit] (the model has no section of them)");
    if (!rays) out.push_back("rays: no view has mode = \"raytrace\"");
    else if (!shadows) out.push_back("shadows: no shaded view asks for them");
    if (rays && !openness) out.push_back("ambient occlusion: no view asks for it");
    std::vector<std::string> rest;
    RenderConfig render;
    const FieldList fields = fields_of(render);
    for (const std::string& name : fields.find("aov")->choices)
        if (name != "all" && name != "lines" && !asked.contains(name)) rest.push_back(name);
    // What "all" passes over is told as missing.
    if (!rest.empty() && !asked.contains("all"))
        out.push_back(fmt::format("{}{}: no view asks for them", kPicturesOf,
                                  fmt::join(rest, ", ")));
    return out;
}

std::string left_out_in_a_line(std::span<const std::string> reasons, const std::string& how) {
    std::vector<std::string> names;
    for (const std::string& reason : reasons)
        if (!reason.starts_with(kLeftToPoints) && !reason.starts_with(kPicturesOf))
            names.push_back(reason.substr(0, reason.find(": ")));
    if (names.empty()) return "";
    return fmt::format("left out: {} (why: {})", fmt::join(names, ", "), how);
}

MissingInViews missing_in_views(std::span<const AskedView> views, const BuildStages& stages) {
    ReasonsOfViews certain, uncertain;
    const int degree = model_degree(stages);
    for (const AskedView& view : views) {
        if (view.refused) continue;
        for (const LineKind kind :
             line_choice(view.render, view.aovs, degree, stages.sharp == "on").lacking)
            (is_crease(kind) && stages.sharp == "auto" ? uncertain : certain)
                .add(view.name,
                     fmt::format("{} lines: {}", line_word(kind), fit_remedy(kind, stages)));
        for (const LeftOut& aov :
             left_out_of_all(view.aovs, degree, stages.color && view.render.add.empty(),
                             stages.given ? SaidBy::options : SaidBy::keys))
            certain.add(view.name, fmt::format("{} of aov all: {}", aov.aovs, aov.reason));
    }
    return {certain.lines(), uncertain.lines()};
}

}  // namespace slim
