// SPDX-License-Identifier: Apache-2.0
//
// Writes a DICOM series for the tests, with any of these deliberate faults:
//
//   make_series FOLDER [KEY=VALUE...]       the keys are the members of struct series (series.h)
//
//   KEY=VALUE -> series -> plan: slices, shuffled -> dataset: attributes, pixels, codec -> damage: bytes of the file
//
// Changes of slice K (from 0; * for every slice), which may be repeated:
//
//   drop=K  double=K:DELTA  move=K:MM  shift=K:X,Y,Z  size=K:NX,NY    a slice is missing, stored twice (with DELTA
//                                                      added to its values), or has another position or size
//   set=K:PATH=VALUE  remove=K:PATH                    an attribute, by DCMTK's path such as PixelSpacing or
//                                                      PerFrameFunctionalGroupsSequence[2].PlanePositionSequence
//   cut= replace= append= bomb= flip=                  the bytes of the file; see damage.h
//
// Prints "slice K FILE" for each file. If a file cannot be written, prints a message and exits with status 1.
#include "dcmtk/config/osconfig.h"

#include "damage.h"
#include "dataset.h"

#include "dcmtk/oflog/oflog.h"

#include <cstdio>

static bool write_series(const series &s, const std::string &folder, std::string *error)
{
    const std::vector<slice> slices = plan_slices(s);
    const size_t step = s.multiframe ? slices.size() : 1;
    for (size_t from = 0; from < slices.size(); from += step) {
        const slice &first = slices[from];
        const std::string path = folder + "/" + first.file;
        const std::vector<slice> frames(&slices[from], &slices[from] + step);
        if (!write_file(s, frames, path, error) || !damage_file(s, first.index, path, error))
            return false;
        printf("slice %d %s\n", first.index, first.file.c_str());
    }
    return true;
}

int main(int argc, char **argv)
{
    series s;
    std::string error;
    OFLog::configure(OFLogger::FATAL_LOG_LEVEL);
    if (argc < 2) {
        fprintf(stderr, "usage: make_series FOLDER [KEY=VALUE...]\n");
        return 1;
    }
    bool good = read_words(argc - 2, argv + 2, &s, &error);
    if (good) {
        open_encoders(s);
        good = write_series(s, argv[1], &error);
        close_encoders();
    }
    if (!good)
        fprintf(stderr, "make_series: %s\n", error.c_str());
    return good ? 0 : 1;
}
