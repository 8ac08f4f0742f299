#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace slim {

/// XXH3-128 of a file's bytes, from the front, in as many steps as one likes: beside a reader of
/// the file what it has just read is still in memory, and no pass over the file is made for the
/// hash alone. One thread at a time. Cost: 1 MiB.
class FileHash {
public:
    /// IoError if it cannot be read, as for all below
    explicit FileHash(const std::filesystem::path& file);
    ~FileHash();
    FileHash(FileHash&&) noexcept;
    FileHash& operator=(FileHash&&) noexcept;

    /// Takes in the bytes up to there, at most those that the file has.
    void advance_to(std::uint64_t end);
    /// Takes in the rest; the hash as 32 hex digits.
    std::string finish();

private:
    struct State;
    /// At most so many, and what one read gives of them. Returns how many; 0 at the file's end.
    std::size_t take(std::uint64_t most);

    std::unique_ptr<State> state_;
};

}  // namespace slim
