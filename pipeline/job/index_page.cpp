#include "pipeline/job/index_page.h"

#include "pipeline/html_page.h"
#include "pipeline/json_text.h"
#include "pipeline/memory_size.h"
#include "pipeline/version.h"
#include "slim/base/markup.h"

#include <fmt/format.h>

#include <utility>

namespace slim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kStyle = R"(h2 { margin-top: 2.2rem; font-size: 1.2rem }
.views { display: grid; grid-template-columns: repeat(auto-fit, minmax(24rem, 1fr)); gap: 1rem }
figure img { max-width: 100%; margin: auto; display: block }
figcaption { padding-top: .3rem }
)";

/// A path for src="...": what a browser would read as something else is percent-encoded.
std::string url_of(const std::string& path) {
    std::string out;
    for (const char c : path) {
        if (c == ' ' || c == '#' || c == '%' || c == '?' || c == '"')
            out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
        else
            out += c;
    }
    return escaped_markup(out);
}

std::string grouped(std::uint64_t n) {
    std::string text = std::to_string(n);
    for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, ",");
    return text;
}

std::string figure_text(const std::string& key, const json& value) {
    if (value.is_number_integer() && key.ends_with("bytes"))
        return memory_size_text(value.get<std::uint64_t>());
    if (value.is_number_unsigned()) return grouped(value.get<std::uint64_t>());
    if (value.is_number()) return fmt::format("{:.4g}", value.get<double>());
    return value.is_string() ? escaped_markup(value.get<std::string>())
                             : escaped_markup(text_of(value));
}

using Columns = std::vector<std::pair<std::string, std::string>>;  // key, heading

/// One row per outcome of the verb; a column that no outcome has is left out.
std::string table_of(const std::vector<StepOutcome>& outcomes, const std::string& verb,
                     const Columns& columns) {
    std::string head, rows;
    Columns present;
    for (const auto& column : columns)
        for (const StepOutcome& outcome : outcomes)
            if (outcome.step.verb == verb && outcome.result.contains(column.first)) {
                present.push_back(column);
                break;
            }
    if (present.empty()) return "";
    for (const auto& [key, heading] : present) head += "<th>" + heading + "</th>";
    for (const StepOutcome& outcome : outcomes) {
        if (outcome.step.verb != verb) continue;
        rows += "<tr><td>" + escaped_markup(outcome.step.name) + "</td>";
        for (const auto& [key, heading] : present)
            rows += "<td>" +
                    (outcome.result.contains(key) ? figure_text(key, outcome.result.at(key)) : "") +
                    "</td>";
        rows += "</tr>\n";
    }
    return "<table>\n<tr><th></th>" + head + "</tr>\n" + rows + "</table>\n";
}

std::string cost_row(const std::string& name, double seconds, double bytes,
                     const std::string& note) {
    return fmt::format("<tr><td>{}</td><td>{:.2f}</td><td>{}</td><td>{}</td></tr>\n", name, seconds,
                       memory_size_text(static_cast<std::uint64_t>(bytes)), note);
}

/// Seconds and peak memory of each step; below a step those of its stages, if it says them.
std::string cost_table(const std::vector<StepOutcome>& outcomes) {
    std::string text =
        "<table>\n<tr><th></th><th>seconds</th><th>peak memory</th><th></th></tr>\n";
    for (const StepOutcome& outcome : outcomes) {
        text +=
            cost_row(escaped_markup(outcome.step.name), outcome.seconds, outcome.peak_memory_bytes,
                     outcome.up_to_date ? "up to date: as recorded" : "");
        if (!outcome.result.contains("stages")) continue;
        const json& stages = outcome.result.at("stages");
        for (const char* name : {"slice", "normals", "fit", "tree"})
            if (stages.contains(name))
                text +=
                    cost_row(std::string("&emsp;") + name, stages.at(name).value("seconds", 0.0),
                             stages.at(name).value("peak_memory_bytes", 0.0), "");
    }
    return text + "</table>\n";
}

/// Of a film's numbered pictures ("spin.mean_0017") all but the first.
bool is_later_frame(const std::string& stem, const StepOutcome& outcome) {
    if (!outcome.result.contains("film_commands") || stem.size() < 5) return false;
    return !stem.ends_with("_0001");
}

std::string pictures_of(const Job& job, const StepOutcome& outcome) {
    std::string text =
                    "<h2>" + escaped_markup(outcome.step.name) + "</h2>\n<div class=\"views\">\n",
                links;
    if (!outcome.result.contains("files")) return "";
    for (const json& file : outcome.result.at("files")) {
        const fs::path path = file.get<std::string>();
        const fs::path relative = fs::absolute(path).lexically_relative(fs::absolute(job.folder));
        if (path.string().ends_with(".lines.svg") || path.string().ends_with(".contours.svg"))
            links +=
                fmt::format("<p class=\"note\"><a href=\"{}\">{}</a></p>\n",
                            url_of(relative.string()), escaped_markup(path.filename().string()));
        if (path.extension() != ".png" || is_later_frame(path.stem().string(), outcome)) continue;
        const std::string caption = path.stem().string();
        text += fmt::format(
            "<figure><a href=\"{0}\"><img src=\"{0}\" alt=\"{1}\" loading=\"lazy\"></a>"
            "<figcaption>{1}</figcaption></figure>\n",
            url_of(relative.string()), escaped_markup(caption));
    }
    text += "</div>\n" + links;
    for (const json& command : outcome.result.value("film_commands", json::array()))
        text += "<p class=\"note\">as a film: <code>" + escaped_markup(command.get<std::string>()) +
                "</code></p>\n";
    return text;
}

/// "scan.ply; diagonal 0.156 mm; fit.t_mdl=0.02": what was read, how large it is, what the call
/// changed.
std::string scan_line(const Job& job, const std::vector<StepOutcome>& outcomes) {
    std::vector<std::string> said;
    for (const StepOutcome& outcome : outcomes) {
        if (outcome.step.verb != "build") continue;
        for (const fs::path& cloud : outcome.step.inputs) said.push_back(cloud.filename().string());
        const json slice =
            outcome.result.value("stages", json::object()).value("slice", json::object());
        if (slice.contains("diagonal"))
            said.push_back(fmt::format("diagonal L = {:.6g} {}", slice.at("diagonal").get<double>(),
                                       job.unit.empty() ? "model units" : job.unit));
    }
    for (const std::string& setting : job.settings)
        if (!setting.starts_with("input.files=") && !setting.starts_with("output.dir="))
            said.push_back(setting);
    return "<p class=\"note\">" + escaped_markup(fmt::format("{}", fmt::join(said, "; "))) +
           "</p>\n";
}

}  // namespace

std::string index_page(const Job& job, const std::vector<StepOutcome>& outcomes) {
    std::string text =
        html_head(job.title, kStyle) + "<h1>" + escaped_markup(job.title) + "</h1>\n";
    text += fmt::format("<p class=\"note\">slim {} &middot; {}</p>\n",
                        escaped_markup(program_version()),
                        escaped_markup(job.file.filename().string()));
    text += scan_line(job, outcomes);
    text += "<h2>Model</h2>\n" +
            table_of(outcomes, "build", {{"points", "points"}, {"leaves", "leaves"},
                                         {"surfels", "surfels"}, {"bytes", "size"}});
    const std::string errors = table_of(
        outcomes, "measure",
        {{"points", "points"}, {"missed", "missed"}, {"l2", "L2 / L"}, {"max", "max / L"},
         {"normal_rms_deg", "normals (RMS, &deg;)"},
         {"mean_curvature_rms_x_diagonal", "mean curvature (RMS &times; L)"},
         {"k1_rms_x_diagonal", "k1 (RMS &times; L)"}, {"k2_rms_x_diagonal", "k2 (RMS &times; L)"}});
    if (!errors.empty())
        text += "<h2>Errors</h2>\n" + errors +
                "<p class=\"note\">L: diagonal of the bounding box of the input; k &gt; 0: "
                "convex</p>\n";
    for (const StepOutcome& outcome : outcomes)
        if (outcome.step.verb == "render") text += pictures_of(job, outcome);
    return text + "<h2>Cost</h2>\n" + cost_table(outcomes) + kHtmlEnd;
}

}  // namespace slim
