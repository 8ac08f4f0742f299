#include "pipeline/build/input_watch.h"

#include "slim/base/error.h"

#include <cstddef>
#include <system_error>

namespace slim {
namespace {

/// A file that is not there has no size; the reader says so.
std::pair<std::uintmax_t, std::filesystem::file_time_type> state_of(const std::string& path) {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(path, error);
    return {size, std::filesystem::last_write_time(path, error)};
}

}  // namespace

InputWatch::InputWatch(std::vector<std::string> paths) : paths_(std::move(paths)) {
    for (const std::string& path : paths_) states_.push_back(state_of(path));
}

void InputWatch::check() const {
    for (std::size_t i = 0; i < paths_.size(); ++i)
        if (state_of(paths_[i]) != states_[i])
            throw DataError(paths_[i] +
                            ": changed while it was read; run the command again when it is "
                            "complete");
}

}  // namespace slim
