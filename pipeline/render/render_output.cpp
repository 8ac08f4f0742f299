#include "pipeline/render/render_output.h"

#include "pipeline/input_kind.h"

namespace slim {
namespace {

bool is_opaque(const Picture8& picture) {
    for (std::size_t i = 3; i < picture.rgba.size(); i += 4)
        if (picture.rgba[i] != 255) return false;
    return true;
}

}  // namespace

void PictureFiles::add_png(std::size_t k, const Picture& band, bool opaque,
                           const ImageMetadata& metadata) {
    const Picture8 encoded = encode_srgb8(band);
    if (!pngs_[k])
        pngs_[k].emplace(plan_.pngs[k].string(), window_.width, window_.height,
                         opaque || (at_once_ && is_opaque(encoded)), metadata);
    pngs_[k]->add_rows(encoded.rgba);
}

void PictureFiles::add_exr(int n_rows, std::span<const ExrChannel> channels,
                           const ImageMetadata& metadata) {
    if (!exr_) {
        const bool is_part = window_.width != whole_.width || window_.height != whole_.height;
        const ImagePlace place =
            is_part ? ImagePlace{window_.x, window_.y, whole_.width, whole_.height} : ImagePlace{};
        exr_.emplace(plan_.exr.string(), window_.width, window_.height, channels, metadata,
                     matrices_, place);
    }
    exr_->add_rows(n_rows, channels);
}

void PictureFiles::add_text(const NamedText& file) {
    if (file.path.has_parent_path()) make_writable_folder(file.path.parent_path());
    texts_.push_back(std::make_unique<AtomicFile>(file.path.string()));
    texts_.back()->write(file.text);
}

void PictureFiles::seal() {
    for (auto& png : pngs_) png->seal();
    if (exr_) exr_->seal();
    for (const auto& text : texts_) text->seal();
    sealed_ = true;
}

std::vector<std::filesystem::path> PictureFiles::commit() {
    if (!sealed_) seal();
    std::vector<std::filesystem::path> files;
    for (std::size_t k = 0; k < pngs_.size(); ++k) {
        pngs_[k]->commit();
        files.push_back(plan_.pngs[k]);
    }
    if (exr_) {
        exr_->commit();
        files.push_back(plan_.exr);
    }
    for (const auto& text : texts_) {
        text->commit();
        files.emplace_back(text->path());
    }
    return files;
}

}  // namespace slim
