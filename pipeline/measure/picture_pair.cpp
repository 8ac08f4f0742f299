#include "pipeline/measure/picture_pair.h"

#include "formats/extension.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <string_view>

namespace slim {

PictureRows::PictureRows(const std::string& path) {
    if (lower_extension(path) == ".png") {
        png_.emplace(path);
        width_ = png_->header().width, height_ = png_->header().height;
        names_ = {"A", "B", "G", "R"};
        return;
    }
    exr_.emplace(path);
    width_ = exr_->header().width, height_ = exr_->header().height;
    for (const auto& [name, channel] : exr_->header().channels) names_.push_back(name);
}

void PictureRows::read(int n_rows) {
    png_ ? png_->read_rows(n_rows, rgba_) : exr_->read_rows(n_rows, channels_);
}

void PictureRows::plane(const std::string& name, std::vector<double>& out) const {
    out.clear();
    if (png_) {
        for (std::size_t i = std::string_view("RGBA").find(name[0]); i < rgba_.size(); i += 4)
            out.push_back(rgba_[i] / 255.0);
        return;
    }
    const ExrImage::Channel& channel = channels_.at(name);
    if (channel.type == ChannelType::uint32)
        out.assign(channel.integers.begin(), channel.integers.end());
    else
        out.assign(channel.floats.begin(), channel.floats.end());
}

PicturePair::PicturePair(const std::string& first, const std::string& second)
    : a_(first), b_(second) {
    if (a_.width() != b_.width() || a_.height() != b_.height())
        throw DataError(
            fmt::format("{} has {}x{} pixels, {} {}x{}: expected two pictures of one size", first,
                        a_.width(), a_.height(), second, b_.width(), b_.height()));
    for (const std::string& name : a_.names())
        if (b_.has(name)) common_.push_back(name);
    if (common_.empty())
        throw DataError(fmt::format("{} and {} have no channel in common", first, second));
}

}  // namespace slim
