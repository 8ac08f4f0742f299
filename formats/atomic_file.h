#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <string>
#include <string_view>
#include <vector>

namespace slim {

/// What half-written files of this process end with: ".tmp.<host>.<space>.<pid>.<random>". Tasks of
/// an array job on several hosts, and containers, write into one folder, where process ids alone
/// would collide: <space> is the number of the namespace that they are of.
const std::string& temporary_suffix();

/// Removes the half-written files of this process, sealed ones too, which nothing may be written to
/// afterwards: for the end by a signal.
void remove_live_temporaries();

/// An output replaces the file of its name; a device, a pipe or a folder is none.
/// throws IoError, exit code `usage`
void check_replaceable(const std::string& path);

/// Whether a new file must outlast a power cut. Files that a job can make anew, and whose damage
/// shows by a checksum, need not: waiting for the disk takes longer than making them.
enum class Outlasts { power_cut, process };

/// A file that appears under its name whole or not at all: written as `name` + temporary_suffix()
/// in the same directory, made if missing, then flushed to disk (unless it may be lost) and renamed
/// by commit(). Without commit() the destructor removes it.
///
/// throws IoError naming the file: exit code `resource` when the disk is full or fails, `usage`
/// when the place cannot be written to at all. What failed once fails again in seal() and commit():
/// libraries that write through it may drop an exception.
/// cost   one buffer of 1 MiB, until it is sealed
class AtomicFile {
public:
    explicit AtomicFile(std::string path);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// Appends n bytes.
    void write(const void* data, std::size_t n);
    void write(std::string_view text) { write(text.data(), text.size()); }
    /// Writes n bytes at a place of its own, before or beyond the end; holes read as zeros.
    void write_at(std::uint64_t offset, const void* data, std::size_t n);
    /// Bytes so far: the furthest one that was written, plus one.
    std::uint64_t size() const;
    /// Everything is on its way to disk, under the temporary name still, and the file is closed:
    /// for several files that appear together or not at all, whose commits can then hardly fail.
    /// Nothing may be written afterwards.
    void seal(Outlasts outlasts = Outlasts::power_cut);
    /// Makes the file visible under its name; nothing may be written afterwards.
    void commit(Outlasts outlasts = Outlasts::power_cut);
    const std::string& path() const { return path_; }

private:
    void flush();
    void put(std::uint64_t offset, const char* data, std::size_t n);
    [[noreturn]] void fail(const char* doing);

    std::string path_;
    std::string temporary_;
    int file_ = -1;
    bool sealed_ = false;         ///< closed, and not yet renamed
    std::uint64_t end_ = 0;       ///< where the buffer belongs
    std::uint64_t furthest_ = 0;  ///< end of what was put to disk
    std::vector<char> buffer_;
    std::exception_ptr failure_;  ///< the first
};

/// Replaces the file by these bytes, atomically. Throws as AtomicFile.
void write_file_atomically(const std::string& path, std::string_view bytes,
                           Outlasts outlasts = Outlasts::power_cut);

}  // namespace slim
