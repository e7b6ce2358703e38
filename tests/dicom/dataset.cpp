// SPDX-License-Identifier: Apache-2.0
//
// The attributes of a file. Every attribute that identifies a person, a place or a time has a known value. The tests
// search all output of osteon for these values.
#include "dcmtk/config/osconfig.h"

#include "dataset.h"
#include "jpeg2000.h"

#include "dcmtk/dcmdata/dcpath.h"
#include "dcmtk/dcmdata/dcpixel.h"
#include "dcmtk/dcmdata/dcpixseq.h"
#include "dcmtk/dcmdata/dcpxitem.h"
#include "dcmtk/dcmdata/dcrleerg.h"
#include "dcmtk/dcmdata/dcrlerp.h"
#include "dcmtk/dcmdata/dctk.h"
#include "dcmtk/dcmjpeg/djencode.h"
#include "dcmtk/dcmjpeg/djrplol.h"
#include "dcmtk/dcmjpeg/djrploss.h"
#include "dcmtk/dcmjpls/djencode.h"
#include "dcmtk/dcmjpls/djrparam.h"

namespace {

// The codecs of DCMTK come first, in the order of the parameters in put_pixels.
enum codec { NATIVE, RLE, JPEG, JPEG_LOSSY, JPEG_LS, JPEG_LS_LOSSY, JPEG_2000, JPEG_2000_LOSSY };

const struct {
    const char *name;
    E_TransferSyntax xfer;
    codec how;
} syntaxes[] = {
    {"implicit", EXS_LittleEndianImplicit, NATIVE},
    {"explicit", EXS_LittleEndianExplicit, NATIVE},
    {"big", EXS_BigEndianExplicit, NATIVE},
    {"deflated", EXS_DeflatedLittleEndianExplicit, NATIVE},
    {"rle", EXS_RLELossless, RLE},
    {"jpeg", EXS_JPEGProcess14, JPEG},
    {"jpeg-sv1", EXS_JPEGProcess14SV1, JPEG},
    {"jpeg-baseline", EXS_JPEGProcess1, JPEG_LOSSY},
    {"jpeg-extended", EXS_JPEGProcess2_4, JPEG_LOSSY},
    {"jpeg-ls", EXS_JPEGLSLossless, JPEG_LS},
    {"jpeg-ls-near", EXS_JPEGLSLossy, JPEG_LS_LOSSY},
    {"jpeg2000", EXS_JPEG2000LosslessOnly, JPEG_2000},
    {"jpeg2000-lossy", EXS_JPEG2000, JPEG_2000_LOSSY},
};

void put(DcmItem *item, const DcmTagKey &tag, const std::string &value)
{
    item->putAndInsertString(tag, value.c_str());
}

std::string uid(int kind, int number)
{
    return "2.25.77777" + std::to_string(kind) + std::to_string(1000 + number);
}

void put_identity(DcmItem *d, const series &s)
{
    static const DcmTagKey texts[] = {
        DCM_AccessionNumber, DCM_DeviceSerialNumber, DCM_EthnicGroup, DCM_ImageComments, DCM_InstitutionAddress,
        DCM_InstitutionName, DCM_InstitutionalDepartmentName, DCM_ManufacturerModelName, DCM_OperatorsName,
        DCM_PatientAddress, DCM_PatientComments, DCM_PerformingPhysicianName, DCM_ProtocolName,
        DCM_RETIRED_OtherPatientIDs, DCM_ReferringPhysicianName, DCM_RequestedProcedureDescription, DCM_StationName,
        DCM_StudyDescription, DCM_StudyID};
    for (const DcmTagKey &tag : texts)
        put(d, tag, "PLANTED");
    static const DcmTagKey dates[] = {DCM_StudyDate, DCM_SeriesDate, DCM_AcquisitionDate, DCM_ContentDate};
    for (const DcmTagKey &tag : dates)
        put(d, tag, "19730405");
    static const DcmTagKey times[] = {DCM_StudyTime, DCM_SeriesTime, DCM_AcquisitionTime, DCM_ContentTime};
    for (const DcmTagKey &tag : times)
        put(d, tag, "053107");
    put(d, DCM_PatientName, "PLANTED^NAME");
    put(d, DCM_PatientID, "PLANTED" + std::to_string(s.patient));
    put(d, DCM_PatientBirthDate, "19010203");
    put(d, DCM_PatientAge, "098Y");
    put(d, DCM_PatientSex, "O");
    put(d, DcmTagKey(0x0009, 0x0010), "PLANTED PRIVATE");
}

void put_series(DcmItem *d, const series &s, const slice &first)
{
    put(d, DCM_SOPClassUID, s.multiframe ? UID_EnhancedCTImageStorage : UID_CTImageStorage);
    put(d, DCM_SOPInstanceUID, uid(6, 0) + "." + std::to_string(s.number) + "." + std::to_string(first.instance) +
                                   (first.file.back() == 'B' ? ".2" : ".1"));
    put(d, DCM_ImageType, "ORIGINAL\\PRIMARY\\AXIAL");
    put(d, DCM_Modality, s.modality);
    put(d, DCM_SeriesDescription, s.description);
    put(d, DCM_ConvolutionKernel, s.kernel);
    put(d, DCM_StudyInstanceUID, uid(1, s.study));
    put(d, DCM_SeriesInstanceUID, uid(2, s.number));
    put(d, DCM_FrameOfReferenceUID, uid(3, s.frame));
    put(d, DCM_SeriesNumber, std::to_string(s.number));
    put(d, DCM_InstanceNumber, std::to_string(first.instance));
}

std::string position(const slice &at)
{
    return decimal(at.position[0]) + "\\" + decimal(at.position[1]) + "\\" + decimal(at.position[2]);
}

std::string directions(const series &s)
{
    std::string text;
    for (int a = 0; a < 6; a++)
        text += (a ? "\\" : "") + decimal(a < 3 ? s.rows[a] : s.columns[a - 3]);
    return text;
}

DcmItem *append(DcmItem *item, const DcmTagKey &sequence)
{
    DcmItem *added = nullptr;
    item->findOrCreateSequenceItem(sequence, added, -2);
    return added;
}

void put_measures(DcmItem *item, const series &s)
{
    put(item, DCM_PixelSpacing, decimal(s.spacing[1]) + "\\" + decimal(s.spacing[0]));
    put(item, DCM_SliceThickness, decimal(s.thickness));
}

void put_rescale(DcmItem *item, const series &s, int k)
{
    put(item, DCM_RescaleIntercept, s.intercept[k % s.intercept.size()]);
    put(item, DCM_RescaleSlope, s.slope[k % s.slope.size()]);
    put(item, DCM_RescaleType, "HU");
}

// All frames have the same spacing and orientation. Each frame has its own position and rescale values.
void put_frames(DcmItem *d, const series &s, const std::vector<slice> &frames)
{
    put(d, DCM_NumberOfFrames, std::to_string(frames.size()));
    DcmItem *shared = append(d, DCM_SharedFunctionalGroupsSequence);
    put_measures(append(shared, DCM_PixelMeasuresSequence), s);
    put(append(shared, DCM_PlaneOrientationSequence), DCM_ImageOrientationPatient, directions(s));
    for (const slice &at : frames) {
        DcmItem *frame = append(d, DCM_PerFrameFunctionalGroupsSequence);
        put(append(frame, DCM_PlanePositionSequence), DCM_ImagePositionPatient, position(at));
        put_rescale(append(frame, DCM_PixelValueTransformationSequence), s, at.index);
    }
}

void put_pixel_description(DcmItem *d, const series &s, const slice &at)
{
    d->putAndInsertUint16(DCM_SamplesPerPixel, 1);
    put(d, DCM_PhotometricInterpretation, s.photometric);
    d->putAndInsertUint16(DCM_Rows, static_cast<Uint16>(at.size[1]));
    d->putAndInsertUint16(DCM_Columns, static_cast<Uint16>(at.size[0]));
    d->putAndInsertUint16(DCM_BitsAllocated, static_cast<Uint16>(s.allocated));
    d->putAndInsertUint16(DCM_BitsStored, static_cast<Uint16>(s.bits));
    d->putAndInsertUint16(DCM_HighBit, static_cast<Uint16>(s.high));
    d->putAndInsertUint16(DCM_PixelRepresentation, s.is_signed);
    static const DcmTagKey keys[] = {DCM_PixelPaddingValue, DCM_PixelPaddingRangeLimit};
    for (size_t p = 0; p < s.padding.size() && p < 2; p++) {
        DcmElement *value;
        if (s.is_signed)
            (value = new DcmSignedShort(DcmTag(keys[p], EVR_SS)))->putSint16(static_cast<Sint16>(s.padding[p]));
        else
            (value = new DcmUnsignedShort(DcmTag(keys[p], EVR_US)))->putUint16(static_cast<Uint16>(s.padding[p]));
        d->insert(value, OFTrue);
    }
}

OFCondition put_native(DcmItem *d, const series &s, const std::vector<uint8_t> &pixels)
{
    // putAndInsertUint16Array is not used, because DCMTK does not compress the element that it makes.
    DcmPixelData *data = new DcmPixelData(DcmTag(DCM_PixelData, s.allocated == 8 ? EVR_OB : EVR_OW));
    const Uint16 *const words = reinterpret_cast<const Uint16 *>(pixels.data());
    const OFCondition done = s.allocated == 8 ? data->putUint8Array(pixels.data(), pixels.size())
                                              : data->putUint16Array(words, pixels.size() / 2);
    return done.good() ? d->insert(data, OFTrue) : done;
}

// DCMTK has no encoder for JPEG 2000, so OpenJPEG encodes the frames, which are inserted without changes.
OFCondition put_jpeg2000(DcmItem *d, const series &s, const std::vector<slice> &frames, E_TransferSyntax xfer,
                         bool lossless)
{
    DcmPixelSequence *sequence = new DcmPixelSequence(DCM_PixelSequenceTag);
    DcmPixelItem *table = new DcmPixelItem(DCM_PixelItemTag);
    sequence->insert(table);
    DcmOffsetList offsets;
    for (const slice &at : frames) {
        std::vector<uint8_t> code = encode_jpeg2000(make_pixels(s, at), at.size[0], at.size[1], s.allocated, s.bits,
                                                    s.is_signed, lossless);
        if (code.empty())
            return EC_CannotChangeRepresentation;
        sequence->storeCompressedFrame(offsets, code.data(), static_cast<Uint32>(code.size()),
                                       static_cast<Uint32>(s.fragment));
    }
    if (s.offsets)
        table->createOffsetTable(offsets);
    DcmPixelData *data = new DcmPixelData(DCM_PixelData);
    data->putOriginalRepresentation(xfer, nullptr, sequence);
    return d->insert(data, OFTrue);
}

OFCondition put_pixels(DcmDataset *d, const series &s, const std::vector<slice> &frames, E_TransferSyntax xfer,
                       codec how)
{
    if (how == JPEG_2000_LOSSY) // for other codecs, the encoders of DCMTK set this attribute
        put(d, DCM_LossyImageCompression, "01");
    if (how == JPEG_2000 || how == JPEG_2000_LOSSY)
        return put_jpeg2000(d, s, frames, xfer, how == JPEG_2000);
    std::vector<uint8_t> pixels;
    for (const slice &at : frames) {
        const std::vector<uint8_t> more = make_pixels(s, at);
        pixels.insert(pixels.end(), more.begin(), more.end());
    }
    if (pixels.size() % 2)
        pixels.push_back(0);
    OFCondition done = put_native(d, s, pixels);
    const DcmRLERepresentationParameter rle;
    const DJ_RPLossless jpeg;
    const DJ_RPLossy jpeg_lossy(95);
    const DJLSRepresentationParameter jpeg_ls(2, OFTrue), jpeg_ls_near(2, OFFalse);
    const DcmRepresentationParameter *const parameters[] = {nullptr, &rle, &jpeg, &jpeg_lossy, &jpeg_ls, &jpeg_ls_near};
    if (done.good() && how != NATIVE)
        done = d->chooseRepresentation(xfer, parameters[how]);
    return done;
}

OFCondition apply_changes(DcmDataset *d, const series &s, int k)
{
    OFCondition done = EC_Normal;
    for (const change &c : s.changes) {
        if (done.bad() || (c.slice != k && c.slice != EVERY_SLICE))
            continue;
        DcmPathProcessor path;
        Uint32 removed;
        if (c.key == "set")
            done = path.applyPathWithValue(d, c.text.c_str());
        else if (c.key == "remove")
            done = path.findOrDeletePath(d, c.text.c_str(), removed);
    }
    return done;
}

} // namespace

void open_encoders(const series &s)
{
    const Uint32 fragment = static_cast<Uint32>(s.fragment);
    DcmRLEEncoderRegistration::registerCodecs(OFFalse, fragment, s.offsets);
    DJEncoderRegistration::registerCodecs(ECC_lossyYCbCr, EUC_never, OFFalse, 0, 0, fragment, s.offsets);
    DJLSEncoderRegistration::registerCodecs(0, 0, 0, 0, OFFalse, fragment, s.offsets, EJLSUC_never);
}

void close_encoders()
{
    DJLSEncoderRegistration::cleanup();
    DJEncoderRegistration::cleanup();
    DcmRLEEncoderRegistration::cleanup();
}

bool write_file(const series &s, const std::vector<slice> &frames, const std::string &path, std::string *error)
{
    DcmFileFormat file;
    DcmDataset *d = file.getDataset();
    const slice &first = frames.front();
    for (const auto &syntax : syntaxes) {
        if (s.syntax != syntax.name)
            continue;
        put_identity(d, s);
        put_series(d, s, first);
        put_pixel_description(d, s, first);
        if (s.multiframe) {
            put_frames(d, s, frames);
        } else {
            put_measures(d, s);
            put(d, DCM_ImageOrientationPatient, directions(s));
            put(d, DCM_ImagePositionPatient, position(first));
            put_rescale(d, s, first.index);
        }
        OFCondition done = put_pixels(d, s, frames, syntax.xfer, syntax.how);
        if (done.good())
            done = apply_changes(d, s, first.index);
        if (done.good())
            done = file.saveFile(path.c_str(), syntax.xfer);
        if (done.bad())
            *error = path + ": " + done.text();
        return done.good();
    }
    *error = "syntax=" + s.syntax + ": expected one of";
    for (const auto &syntax : syntaxes)
        *error += std::string(" ") + syntax.name;
    return false;
}
