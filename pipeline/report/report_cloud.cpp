#include "pipeline/report/report_cloud.h"

#include "formats/atomic_file.h"
#include "formats/extension.h"
#include "formats/ply_writer.h"
#include "formats/point_source.h"
#include "formats/truth_file.h"
#include "slim/base/bbox.h"
#include "slim/base/hash.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <numbers>
#include <optional>

namespace slim {
namespace {

constexpr std::size_t kChunk = 1 << 16;

/// What formulas may name, in the order of PointValues.
constexpr std::array kNames = {"x",  "y",  "z", "nx", "ny",   "nz", "k1", "k2", "i",
                               "n",  "file", "r1", "r2", "r3", "r4", "g1", "g2", "g3"};
using PointValues = std::array<double, kNames.size()>;
enum Place : std::size_t { kX = 0, kNormal = 3, kCurvature = 6, kIndex = 8, kCount = 9, kFile = 10,
                           kUniform = 11, kGauss = 15 };
constexpr std::size_t kTargets = 8;  // the first ones can be set

void put_random(std::uint64_t seed, std::uint64_t i, PointValues& v) {
    const auto uniform = [&](std::uint64_t k) { return unit_interval(keyed_hash(seed, i, k)); };
    for (std::size_t k = 0; k < 4; ++k) v[kUniform + k] = uniform(k + 1);
    for (std::size_t k = 0; k < 3; ++k)  // Box and Muller
        v[kGauss + k] = std::sqrt(-2 * std::log(1 - uniform(10 + 2 * k))) *
                        std::cos(2 * std::numbers::pi * uniform(11 + 2 * k));
}

/// A formula with its names resolved: numbers of the point, or constants of the row.
class PointFormula {
public:
    PointFormula(const Expression& formula, const Expression::Lookup& row) : formula_(formula) {
        for (const std::string& name : formula.names()) {
            const auto found = std::find(kNames.begin(), kNames.end(), name);
            places_.push_back(static_cast<std::size_t>(found - kNames.begin()));
            values_.push_back(found == kNames.end() ? row(name).number : 0);
        }
    }
    double operator()(const PointValues& point) {
        for (std::size_t k = 0; k < places_.size(); ++k)
            if (places_[k] < point.size()) values_[k] = point[places_[k]];
        return formula_.number(values_);
    }

private:
    const Expression& formula_;
    std::vector<std::size_t> places_;
    std::vector<double> values_;
};

/// Takes points as they come and writes them.
class CloudOutput {
public:
    CloudOutput(const std::string& path, bool normals, bool truth, bool single) {
        if (lower_extension(path) != ".ply") {
            text_.emplace(path);
            return;
        }
        PlyLayout layout;
        layout.double_positions = !single;
        layout.normals = normals;
        ply_.emplace(path, layout);
        if (truth) truth_.emplace(truth_path(path));
    }
    void add(const PointValues& v) {
        positions_.push_back({v[0], v[1], v[2]});
        normals_.push_back(
            {static_cast<float>(v[3]), static_cast<float>(v[4]), static_cast<float>(v[5])});
        truths_.push_back({{v[3], v[4], v[5]}, v[6], v[7]});
        box_.extend(positions_.back());
        if (positions_.size() >= kChunk) flush();
    }
    nlohmann::json commit() {
        flush();
        if (truth_) truth_->commit();
        if (ply_) ply_->commit();
        if (text_) text_->commit();
        return {{"points", n_}, {"diagonal", n_ > 0 ? box_.diagonal() : 0}};
    }

private:
    void flush() {
        n_ += positions_.size();
        if (ply_) ply_->write({positions_, normals_, {}, {}, {}});
        if (truth_) truth_->write(truths_);
        if (text_)
            for (std::size_t i = 0; i < positions_.size(); ++i)
                text_->write(fmt::format("{} {} {} {} {} {}\n", positions_[i].x, positions_[i].y,
                                         positions_[i].z, normals_[i].x, normals_[i].y,
                                         normals_[i].z));
        positions_.clear(), normals_.clear(), truths_.clear();
    }

    std::optional<PlyWriter> ply_;
    std::optional<TruthWriter> truth_;
    std::optional<AtomicFile> text_;
    std::vector<Vec3d> positions_;
    std::vector<Vec3f> normals_;
    std::vector<PointTruth> truths_;
    Bbox box_;
    std::uint64_t n_ = 0;
};

/// All of a cloud's points, with their truth if they have it.
class CloudInput {
public:
    CloudInput(const std::string& path, bool truth) : source_(open_cloud(path)), path_(path) {
        if (truth) truth_file_.emplace(truth_path(path));
    }
    const CloudInfo& info() const { return source_->info(); }
    /// Calls take(values) for each point; x ... k2 are set.
    template <class Take>
    void for_each(Take&& take) {
        PointChunk chunk;
        std::vector<PointTruth> truth;  // of the chunk
        while (source_->read(chunk, kChunk)) {
            if (truth_file_) truth_file_->read(chunk.size(), path_, truth);
            for (std::size_t i = 0; i < chunk.size(); ++i) {
                PointValues v{};
                const Vec3d& p = chunk.position[i];
                const Vec3d n = truth_file_            ? truth[i].normal
                                : chunk.normal.empty() ? Vec3d{}
                                                       : to_double(chunk.normal[i]);
                v[0] = p.x, v[1] = p.y, v[2] = p.z, v[3] = n.x, v[4] = n.y, v[5] = n.z;
                if (truth_file_) v[6] = truth[i].k1, v[7] = truth[i].k2;
                take(v);
            }
        }
    }

private:
    std::unique_ptr<PointSource> source_;
    std::string path_;
    std::optional<TruthReader> truth_file_;
};

bool names_any(const std::vector<std::pair<std::string, Expression>>& formulas, const char* a,
               const char* b) {
    return std::any_of(formulas.begin(), formulas.end(),
                       [&](const auto& f) { return f.first == a || f.first == b; });
}

}  // namespace

nlohmann::json make_cloud(const std::vector<std::string>& from, std::uint64_t n_points,
                          const std::vector<std::pair<std::string, Expression>>& formulas,
                          const Expression::Lookup& row, std::uint64_t seed, bool single,
                          const std::string& output) {
    std::vector<std::pair<std::size_t, PointFormula>> sets;
    std::optional<PointFormula> keep;
    for (const auto& [target, formula] : formulas) {
        const auto place = std::find(kNames.begin(), kNames.begin() + kTargets, target);
        if (target == "keep")
            keep.emplace(formula, row);
        else
            sets.emplace_back(static_cast<std::size_t>(place - kNames.begin()),
                              PointFormula(formula, row));
    }
    bool normals = names_any(formulas, "nx", "nz"), truth = names_any(formulas, "k1", "k2");
    const bool all_truth =
        !from.empty() && std::all_of(from.begin(), from.end(), [](const std::string& f) {
            return std::filesystem::exists(truth_path(f));
        });
    truth = truth || all_truth;
    double n = static_cast<double>(n_points);
    for (const std::string& file : from) {
        const CloudInfo info = open_cloud(file)->info();
        normals = normals || info.has_normals;
        n += static_cast<double>(info.n_points.value_or(0));
    }
    CloudOutput out(output, normals, truth, single);
    std::uint64_t i = 0;
    double file_number = 0;
    const auto take = [&](PointValues v) {
        v[kIndex] = static_cast<double>(i), v[kCount] = n, v[kFile] = file_number;
        put_random(seed, i++, v);
        PointValues set = v;  // formulas see the point as it was
        for (auto& [place, formula] : sets) set[place] = formula(v);
        if (!keep || (*keep)(v) != 0) out.add(set);
    };
    for (std::uint64_t k = 0; k < n_points; ++k) take(PointValues{});
    for (const std::string& file : from) {
        CloudInput(file, all_truth).for_each(take);
        file_number += 1;
    }
    return out.commit();
}

}  // namespace slim
