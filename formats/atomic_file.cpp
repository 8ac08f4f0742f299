#include "formats/atomic_file.h"

#include "formats/dead_temporaries.h"
#include "formats/made_folders.h"
#include "formats/message.h"
#include "slim/base/check.h"
#include "slim/base/error.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <mutex>
#include <set>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace slim {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 20;

std::string folder_of(const std::string& path) {
    const auto slash = path.rfind('/');
    return slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
}

/// Names of files that are open or sealed, for all threads.
class LiveTemporaries {
public:
    void insert(const std::string& name) {
        const std::lock_guard guard(mutex_);
        names_.insert(name);
    }
    void erase(const std::string& name) {
        const std::lock_guard guard(mutex_);
        names_.erase(name);
    }
    void remove_files() {
        const std::lock_guard guard(mutex_);
        for (const std::string& name : names_) ::unlink(name.c_str());
    }

private:
    std::mutex mutex_;
    std::set<std::string> names_;
};
LiveTemporaries& live_temporaries() {
    static LiveTemporaries all;
    return all;
}

int open_new(const std::string& path) {
    return ::open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
}

void make_folder_of(const std::string& path) {
    try {
        make_folders(folder_of(path));
    } catch (const IoError& error) {
        throw IoError(path + ": " + error.what(), error.code());
    }
}

std::string host_name() {
    char host[256] = {};
    ::gethostname(host, sizeof host - 1);
    return host;
}

/// The kernel's number of the space in which this process has its number: a container has one of
/// its own, often under its host's name. "0" where /proc does not tell.
std::string process_space() {
    struct stat space {};
    return ::stat("/proc/self/ns/pid", &space) == 0 ? std::to_string(space.st_ino) : "0";
}

/// The new name must survive a power cut too; a file system that cannot sync a folder is no error.
void sync_folder(const std::string& folder) {
    const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return;
    ::fsync(fd);
    ::close(fd);
}

}  // namespace

void remove_live_temporaries() { live_temporaries().remove_files(); }

const std::string& temporary_suffix() {
    static const std::string suffix = [] {
        std::uint32_t random = 0;
        if (::getentropy(&random, sizeof random) != 0)
            random = static_cast<std::uint32_t>(
                std::chrono::steady_clock::now().time_since_epoch().count());
        char text[16];
        std::snprintf(text, sizeof text, "%08x", random);
        return ".tmp." + host_name() + "." + process_space() + "." + std::to_string(::getpid()) +
               "." + text;
    }();
    return suffix;
}

void check_replaceable(const std::string& path) {
    struct stat found {};
    if (::stat(path.c_str(), &found) != 0 || S_ISREG(found.st_mode)) return;
    throw IoError(
        {.file = path,
         .problem = message("is a ", S_ISDIR(found.st_mode) ? "folder" : "device or pipe",
                            "; expected the name of a file to write, which takes its place")},
        ExitCode::usage);
}

AtomicFile::AtomicFile(std::string path)
    : path_(std::move(path)), temporary_(path_ + temporary_suffix()) {
    check_replaceable(path_);
    remove_dead_temporaries(path_);
    file_ = open_new(temporary_);
    if (file_ < 0 && errno == ENOENT) {
        make_folder_of(path_);
        file_ = open_new(temporary_);
    }
    if (file_ < 0) {
        const bool full = errno == ENOSPC || errno == EDQUOT || errno == EMFILE || errno == ENFILE;
        throw IoError(
            {.file = path_, .problem = message("cannot be created: ", std::strerror(errno))},
            full ? ExitCode::resource : ExitCode::usage);
    }
    live_temporaries().insert(temporary_);
    // To be seen alive by others, also by those of another host of this one's name.
    ::flock(file_, LOCK_EX | LOCK_NB);
}

AtomicFile::~AtomicFile() {
    if (file_ < 0 && !sealed_) return;
    if (file_ >= 0) ::close(file_);
    ::unlink(temporary_.c_str());
    live_temporaries().erase(temporary_);
}

void AtomicFile::fail(const char* doing) {
    const int error = errno;
    const char* const hint = error == EFBIG ? " (see `ulimit -f`)" : "";
    failure_ = std::make_exception_ptr(
        IoError(message(path_, ": byte ", furthest_, ": ", doing, ": ", std::strerror(error), hint),
                ExitCode::resource));
    std::rethrow_exception(failure_);
}

void AtomicFile::put(std::uint64_t offset, const char* data, std::size_t n) {
    while (n > 0) {
        const ssize_t done = ::pwrite(file_, data, n, static_cast<off_t>(offset));
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) fail("cannot be written");
        data += done;
        offset += static_cast<std::uint64_t>(done);
        n -= static_cast<std::size_t>(done);
        furthest_ = std::max(furthest_, offset);
    }
}

void AtomicFile::flush() {
    put(end_, buffer_.data(), buffer_.size());
    end_ += buffer_.size();
    buffer_.clear();
}

void AtomicFile::write(const void* data, std::size_t n) {
    SLIM_CHECK(file_, >=, 0);
    const char* bytes = static_cast<const char*>(data);
    if (buffer_.size() + n > kBufferSize) flush();
    if (n >= kBufferSize) {
        put(end_, bytes, n);
        end_ += n;
    } else {
        // not before: hundreds of slices are open at once and never write here
        buffer_.reserve(kBufferSize);
        buffer_.insert(buffer_.end(), bytes, bytes + n);
    }
}

void AtomicFile::write_at(std::uint64_t offset, const void* data, std::size_t n) {
    SLIM_CHECK(file_, >=, 0);
    flush();
    put(offset, static_cast<const char*>(data), n);
}

std::uint64_t AtomicFile::size() const { return std::max(furthest_, end_ + buffer_.size()); }

void AtomicFile::seal(Outlasts outlasts) {
    SLIM_CHECK(file_, >=, 0);
    if (failure_) std::rethrow_exception(failure_);
    flush();
    const bool to_disk = outlasts == Outlasts::power_cut;
    if (to_disk && ::fsync(file_) != 0 && errno != EINVAL && errno != EROFS)
        fail("cannot be flushed to disk");
    const int closed = ::close(file_);
    file_ = -1;
    // sealed files may be many: the pictures of a film that show nothing yet
    std::vector<char>().swap(buffer_);
    sealed_ = true;
    if (closed != 0 && errno != EINTR) fail("cannot be closed");  // quotas of network file systems
}

void AtomicFile::commit(Outlasts outlasts) {
    if (!sealed_) seal(outlasts);
    if (failure_) std::rethrow_exception(failure_);
    if (::rename(temporary_.c_str(), path_.c_str()) != 0) fail("cannot be renamed into place");
    sealed_ = false;
    live_temporaries().erase(temporary_);
    if (outlasts == Outlasts::power_cut) sync_folder(folder_of(path_));
}

void write_file_atomically(const std::string& path, std::string_view bytes, Outlasts outlasts) {
    AtomicFile file(path);
    file.write(bytes);
    file.commit(outlasts);
}

}  // namespace slim
