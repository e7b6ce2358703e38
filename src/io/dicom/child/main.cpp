// SPDX-License-Identifier: Apache-2.0
//
// Reads a request from standard input, and writes the answer to standard output.
#include "io/dicom/child/child.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

#include <sys/uio.h>
#include <unistd.h>

#include <dcmtk/dcmdata/dcrledrg.h>
#include <dcmtk/dcmjpeg/djdecode.h>
#include <dcmtk/dcmjpls/djdecode.h>
#include <dcmtk/oflog/oflog.h>

enum { EXIT_BAD_REQUEST = 2 };

void send_message(ost_dicom_type type, uint32_t index, const void *payload, size_t size)
{
    ost_dicom_message message = {static_cast<uint32_t>(type), index, static_cast<uint32_t>(size)};
    struct iovec parts[2] = {{&message, sizeof message}, {const_cast<void *>(payload), size}};
    struct iovec *part = parts;
    int left = size ? 2 : 1;
    while (left) {
        const ssize_t n = writev(STDOUT_FILENO, part, left);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            _exit(EXIT_FAILURE);
        size_t done = static_cast<size_t>(n);
        while (left && done >= part->iov_len) {
            done -= part->iov_len;
            part++;
            left--;
        }
        if (left) {
            part->iov_base = static_cast<char *>(part->iov_base) + done;
            part->iov_len -= done;
        }
    }
}

static bool read_exactly(void *to, size_t size)
{
    char *at = static_cast<char *>(to);
    while (size) {
        const ssize_t n = read(STDIN_FILENO, at, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return false;
        at += n;
        size -= static_cast<size_t>(n);
    }
    return true;
}

static bool read_paths(uint32_t count, std::vector<std::string> &paths)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t length;
        if (!read_exactly(&length, sizeof length) || length == 0 || length >= OST_DICOM_PATH_MAX)
            return false;
        std::string path(length, '\0');
        if (!read_exactly(&path[0], length))
            return false;
        paths.push_back(path);
    }
    return true;
}

static void send_result(uint32_t index, ost_dicom_result result)
{
    const uint32_t payload = result;
    send_message(OST_DICOM_FILE, index, &payload, sizeof payload);
}

static void scan(const std::vector<std::string> &paths, const uint8_t salt[OST_DICOM_SALT])
{
    for (uint32_t i = 0; i < paths.size(); i++) {
        ost_dicom_result result = OST_DICOM_RESULT_MEMORY;
        try {
            result = scan_file(paths[i].c_str(), i, salt);
        } catch (const std::bad_alloc &) {
        }
        send_result(i, result);
    }
}

// Sends the pixels of every image. Stops after the first failure, because a volume needs all of its slices.
static void read_images(const std::vector<std::string> &paths, const std::vector<ost_dicom_image> &images)
{
    open_file from;
    std::vector<uint16_t> cells;
    for (uint32_t i = 0; i < images.size(); i++) {
        ost_dicom_result result = OST_DICOM_RESULT_MEMORY;
        try {
            result = read_image(from, paths[images[i].file].c_str(), images[i], cells);
        } catch (const std::bad_alloc &) {
        }
        if (result != OST_DICOM_RESULT_OK) {
            send_result(i, result);
            return;
        }
        send_message(OST_DICOM_PIXELS, i, cells.data(), cells.size() * sizeof cells[0]);
    }
}

int main()
{
    ost_dicom_request request;
    std::vector<std::string> paths;
    if (!read_exactly(&request, sizeof request) || request.magic != OST_DICOM_MAGIC ||
        request.version != OST_DICOM_VERSION || request.paths > OST_DICOM_FILES_MAX ||
        request.images > OST_DICOM_IMAGES_MAX || !read_paths(request.paths, paths))
        return EXIT_BAD_REQUEST;
    std::vector<ost_dicom_image> images(request.images);
    if (request.images && !read_exactly(images.data(), images.size() * sizeof images[0]))
        return EXIT_BAD_REQUEST;
    for (const ost_dicom_image &image : images)
        if (image.file >= request.paths || image.columns == 0 || image.columns > OST_DICOM_SIDE_MAX ||
            image.rows == 0 || image.rows > OST_DICOM_SIDE_MAX)
            return EXIT_BAD_REQUEST;
    OFLog::configure(OFLogger::OFF_LOG_LEVEL);
    if (request.action == OST_DICOM_SCAN) {
        scan(paths, request.salt);
    } else {
        DJDecoderRegistration::registerCodecs();
        DJLSDecoderRegistration::registerCodecs();
        DcmRLEDecoderRegistration::registerCodecs();
        read_images(paths, images);
    }
    send_message(OST_DICOM_END, 0, nullptr, 0);
    return EXIT_SUCCESS;
}
