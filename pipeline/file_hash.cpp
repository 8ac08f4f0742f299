#include "pipeline/file_hash.h"

#include "slim/base/error.h"

#define XXH_STATIC_LINKING_ONLY  // XXH3_state_t as a member
#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

#include <fcntl.h>
#include <unistd.h>

namespace slim {
namespace {

constexpr std::size_t kReadSize = std::size_t{1} << 20;

[[noreturn]] void fail(const std::filesystem::path& file) {
    throw IoError(fmt::format("{}: cannot read: {}", file.string(), std::strerror(errno)));
}

}  // namespace

struct FileHash::State {
    std::filesystem::path file;
    int descriptor;
    std::uint64_t done = 0;
    XXH3_state_t hash;
    std::unique_ptr<char[]> buffer = std::make_unique_for_overwrite<char[]>(kReadSize);

    explicit State(const std::filesystem::path& of)
        : file(of), descriptor(open(of.c_str(), O_RDONLY | O_CLOEXEC)) {
        if (descriptor < 0) fail(file);
        XXH3_128bits_reset(&hash);
    }
    ~State() { close(descriptor); }
    State(const State&) = delete;
    State& operator=(const State&) = delete;
};

FileHash::FileHash(const std::filesystem::path& file) : state_(std::make_unique<State>(file)) {}
FileHash::~FileHash() = default;
FileHash::FileHash(FileHash&&) noexcept = default;
FileHash& FileHash::operator=(FileHash&&) noexcept = default;

std::size_t FileHash::take(std::uint64_t most) {
    State& s = *state_;
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(most, kReadSize));
    for (;;) {
        const ssize_t n = read(s.descriptor, s.buffer.get(), wanted);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail(s.file);
        const auto got = static_cast<std::size_t>(n);
        XXH3_128bits_update(&s.hash, s.buffer.get(), got);
        s.done += got;
        return got;
    }
}

void FileHash::advance_to(std::uint64_t end) {
    while (state_->done < end && take(end - state_->done) > 0) {
    }
}

std::string FileHash::finish() {
    advance_to(std::numeric_limits<std::uint64_t>::max());
    const XXH128_hash_t hash = XXH3_128bits_digest(&state_->hash);
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace slim
