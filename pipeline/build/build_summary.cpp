#include "pipeline/build/build_summary.h"

#include "formats/model_file.h"
#include "pipeline/build/edges_said.h"
#include "pipeline/memory_size.h"
#include "pipeline/noise_over_diagonal.h"
#include "pipeline/shell_word.h"
#include "slim/tree/drawn_bounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>

namespace slim {
namespace {

constexpr double kManySaturated = 0.1;  // of the leaves: a larger t_mdl no longer makes them larger

std::uint64_t count(const nlohmann::json& of, const char* key) {
    return of.value(key, std::uint64_t{0});
}

/// "1 point", "2 points".
std::string counted(std::uint64_t n, const std::string& one, const std::string& many = "") {
    return fmt::format("{} {}", n, n == 1 ? one : many.empty() ? one + "s" : many);
}

std::string costs(const nlohmann::json& stages) {
    std::string text = "seconds:";
    double memory = 0;
    for (const char* name : {"slice", "normals", "fit", "tree"}) {
        text += fmt::format(" {} {:.2f},", name, stages.at(name).value("seconds", 0.0));
        memory = std::max(memory, stages.at(name).value("peak_memory_bytes", 0.0));
    }
    text.back() = ';';
    return text + " peak memory " + memory_size_text(static_cast<std::uint64_t>(memory)) + "\n";
}

/// Strays far from the rest make L large, and with it what T_MDL and every figure over L mean.
std::string stretched_diagonal(const nlohmann::json& result) {
    constexpr double kMuch = 2;
    const double whole = result.at("stages").at("slice").at("diagonal").get<double>();
    const double drawn = result.value("drawn_diagonal", whole);
    if (!(whole > kMuch * drawn && drawn > 0)) return "";
    return fmt::format(
        "far points stretch the diagonal to L = {:.4g}, of what is drawn it is {:.4g}: t_mdl and "
        "errors over L count {:.3g} times; take the far points out, or divide --t-mdl by that\n",
        whole, drawn, whole / drawn);
}

/// What there is to say of estimated normals whose pieces say nothing of each other.
std::string guessed_sides(const nlohmann::json& result, std::uint64_t n_estimated) {
    const auto& normals = result.at("stages").at("normals");
    const std::uint64_t pieces = count(normals, "unanchored_components");
    if (pieces < 2 || 2 * count(normals, "oriented_by_rule") < n_estimated) return "";
    return fmt::format(
        "; which side of each of {} pieces is out is told by its shape alone (--sensors: where "
        "the scanner stood)",
        pieces);
}

/// What a user may want to know of a cloud that was not as it should be; empty if it was.
std::string remarks(const nlohmann::json& result) {
    std::string text;
    const auto& slice = result.at("stages").at("slice");
    const auto& fit = result.at("stages").at("fit");
    if (const auto n = count(result, "dropped"))
        text += fmt::format("not finite, dropped: {}\n", counted(n, "point"));
    if (const auto n = count(slice, "face_points"))
        text += fmt::format("added on large faces: {} (--face-points off: vertices alone)\n",
                            counted(n, "point"));
    if (const auto n = count(result, "normals_estimated"))
        text += fmt::format("normals estimated: {}{}\n", n, guessed_sides(result, n));
    if (const auto n = count(result, "normals_turned"))
        text += fmt::format("normals turned: {}\n", n);
    if (const auto n = count(fit, "copies"))
        text += fmt::format("at the place of another, left out: {}\n", counted(n, "point"));
    if (const auto n = count(fit, "dropped_isolated") + count(fit, "dropped_unexplained") +
                       count(fit, "dropped_beside"))
        text += fmt::format("strays, left out: {}\n", counted(n, "point"));
    if (const std::string edges = edges_text(result, Remedies::of_a_command); !edges.empty())
        text += edges + "\n";
    text += stretched_diagonal(result);
    if (const auto n = count(result, "loose"))
        text += fmt::format(
            "loose, not drawn: {} of no surface about {} (slim render --loose draws {})\n",
            counted(n, "leaf", "leaves"), n == 1 ? "it" : "them", n == 1 ? "it" : "them");
    const std::uint64_t leaves = count(result, "leaves"), saturated = count(fit, "saturated");
    // Errors of rounding have no detail below them.
    constexpr double kRounding = 1e-7;
    if (result.value("leaf_error_rms", 0.0) > kRounding &&
        static_cast<double>(saturated) > kManySaturated * static_cast<double>(leaves))
        text += fmt::format(
            "{} of {} leaves are as large as they may be: the scan's noise, or t_mdl, outweighs "
            "their fit error; a larger t_mdl changes little, a smaller one shows more detail\n",
            saturated, leaves);
    return text;
}

}  // namespace

double leaf_error_rms(const std::string& model) {
    const ModelFile file = ModelFile::open(model);
    double sum = 0, n = 0;
    for (const TreeNode& node : file.tree().nodes()) {
        if (!node.is_leaf() || file.header().n_leaves == 0) continue;
        const double points = node.n_points, error = static_cast<double>(node.fit_error);
        sum += points * error * error;
        n += points;
    }
    return n > 0 ? std::sqrt(sum / n) / file.header().diagonal : 0;
}

double drawn_diagonal(const std::string& model) {
    return drawn_bounds(ModelFile::open(model).tree(), false).diagonal();
}

std::string build_summary(const std::string& model, const std::vector<std::string>& clouds,
                          const nlohmann::json& result) {
    const double diagonal = result.at("stages").at("slice").at("diagonal").get<double>();
    const double lambda = result.value("noise_variance", 0.0),
                 typical = result.value("typical_variance", lambda);
    const nlohmann::json& fit = result.at("stages").at("fit");
    std::string noise = fmt::format("noise {:.2g} of L", noise_over_diagonal(lambda, diagonal));
    if (2 * fit.value("step_variance", 0.0) > lambda)
        noise += " (of coordinates in steps)";
    else if (is_mostly_edges(lambda, typical))
        noise += fmt::format(" (of edges and bends; {:.2g} at a typical place)",
                             noise_over_diagonal(typical, diagonal));
    std::string text = fmt::format(
        "{}: {}, {}, {}; fit error {:.2g} of L, the diagonal (RMS of each leaf alone), {}\n",
        model, counted(count(result, "points"), "point"),
        counted(count(result, "leaves"), "leaf", "leaves"),
        memory_size_text(count(result, "bytes")), result.value("leaf_error_rms", 0.0), noise);
    text += costs(result.at("stages")) + remarks(result);
    const std::string picture = std::filesystem::path(model).replace_extension(".png").string();
    text += "next: " + shell_line({"slim", "render", model, "-o", picture}) + "\n";
    return text + "      " + shell_line({"slim", "measure", model, clouds.at(0)}) +
           "   (l2: RMS distance of the points to the leaves as they blend)\n";
}

}  // namespace slim
