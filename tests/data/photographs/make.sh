#!/bin/sh
# Makes the pictures of this folder with programs that are not ours: ImageMagick 6 and ExifTool.
# `upright.png` holds the pixels as stored; `turned-N.png` is what ImageMagick makes of it under EXIF orientation N.
set -e
cd "$(dirname "$0")"
pixels() { awk -v n="$1" -v k="$2" 'BEGIN { for (i = 0; i < n; i++) printf "%c", 1 + (i * i * 7 + i * k) % 126 }'; }
pixels 72 31 | convert -size 6x4 -depth 8 rgb:- -strip png24:upright.png
convert upright.png -quality 100 -sampling-factor 4:4:4 stored.jpg
for n in 2 3 4 5 6 7 8; do
    convert upright.png -compress none -strip tagged-$n.tif
    exiftool -q -overwrite_original -Orientation=$n -n tagged-$n.tif
    convert tagged-$n.tif -auto-orient +profile '*' -strip png24:turned-$n.png
done
cp stored.jpg tagged-6.jpg
exiftool -q -overwrite_original -Orientation=6 -n -FocalLengthIn35mmFormat=50 \
    -DateTimeOriginal='2024:05:01 12:00:03' -SubSecTimeOriginal=25 tagged-6.jpg
# EXIF data ahead of the pixels, and behind them.
cp upright.png tagged-6.png
exiftool -q -overwrite_original -Orientation=6 -n tagged-6.png
convert tagged-6.jpg behind-6.png
convert tagged-6.jpg -auto-orient -strip png24:behind-turned-6.png
convert upright.png -define webp:lossless=true tagged-6.webp
exiftool -q -overwrite_original -Orientation=6 -n tagged-6.webp
convert upright.png -orient RightTop -compress lzw TIFF64:big-6.tif
pixels 144 57 | convert -size 6x4 -depth 16 -endian lsb rgb:- -strip png48:deep.png
convert deep.png -depth 16 -compress zip deep.tif
convert deep.png -depth 16 -compress none TIFF64:deep-big.tif
convert deep.png -depth 16 txt:deep.txt
convert upright.png -scale 32x32! telephone.heic
