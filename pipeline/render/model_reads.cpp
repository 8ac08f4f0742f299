#include "pipeline/render/model_reads.h"

namespace slim {
namespace {

/// Models up to this size are checked whole, checksums and all: for 2.7 MB that is below the noise
/// of a run of 0.24 s.
constexpr std::uint64_t kCheckedWhole = std::uint64_t{16} << 20;

}  // namespace

ModelReads::ModelReads(const ModelFile& model, bool taken_whole, bool with_colors)
    : model_(model), pages_(model) {
    if (with_colors) {
        model.check_colors();
        color_bytes_ = model.colors_size();
    }
    const SurfelTree tree = model.tree();
    if (taken_whole || model.surface_size() <= kCheckedWhole || !tree.sharp().empty())
        check_whole();
    else
        met_.resize(tree.n_nodes());
}

void ModelReads::meet(std::span<const std::uint32_t> nodes) {
    if (whole_) return;
    fresh_.clear();
    for (const std::uint32_t i : nodes) {
        if (met_[i]) continue;
        met_[i] = true;
        fresh_.push_back(i);
        pages_.add(i);
    }
    if (2 * pages_.bytes() >= model_.surface_size()) return check_whole();
    model_.check(fresh_);
    n_checked_ += fresh_.size();
}

void ModelReads::check_whole() {
    model_.check();
    whole_ = true;
    met_ = {};
    fresh_ = {};
}

}  // namespace slim
