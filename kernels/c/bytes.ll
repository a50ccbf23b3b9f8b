; ModuleID = 'bytes.c'
source_filename = "bytes.c"
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"
target triple = "x86_64-pc-linux-gnu"

@crc_of_nibble = internal unnamed_addr constant [16 x i32] [i32 0, i32 498536548, i32 997073096, i32 651767980, i32 1994146192, i32 1802195444, i32 1303535960, i32 1342533948, i32 -306674912, i32 -267414716, i32 -690576408, i32 -882789492, i32 -1687895376, i32 -2032938284, i32 -1609899400, i32 -1111625188], align 16, !dbg !0
@digits.letters = internal unnamed_addr constant [37 x i8] c"0123456789abcdefghijklmnopqrstuvwxyz\00", align 16, !dbg !15

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @crc32_table(ptr nocapture noundef readonly %0, i32 noundef %1) local_unnamed_addr #0 !dbg !46 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !52, metadata !DIExpression()), !dbg !57
  call void @llvm.dbg.value(metadata i32 %1, metadata !53, metadata !DIExpression()), !dbg !57
  call void @llvm.dbg.value(metadata i32 -1, metadata !54, metadata !DIExpression()), !dbg !57
  call void @llvm.dbg.value(metadata i32 0, metadata !55, metadata !DIExpression()), !dbg !58
  %3 = icmp sgt i32 %1, 0, !dbg !59
  br i1 %3, label %4, label %8, !dbg !61

4:                                                ; preds = %2
  %5 = zext i32 %1 to i64, !dbg !59
  br label %10, !dbg !61

6:                                                ; preds = %10
  %7 = xor i32 %28, -1, !dbg !62
  br label %8, !dbg !62

8:                                                ; preds = %6, %2
  %9 = phi i32 [ 0, %2 ], [ %7, %6 ]
  ret i32 %9, !dbg !63

10:                                               ; preds = %4, %10
  %11 = phi i64 [ 0, %4 ], [ %29, %10 ]
  %12 = phi i32 [ -1, %4 ], [ %28, %10 ]
  call void @llvm.dbg.value(metadata i64 %11, metadata !55, metadata !DIExpression()), !dbg !58
  call void @llvm.dbg.value(metadata i32 %12, metadata !54, metadata !DIExpression()), !dbg !57
  %13 = getelementptr inbounds i8, ptr %0, i64 %11, !dbg !64
  %14 = load i8, ptr %13, align 1, !dbg !64, !tbaa !66
  %15 = zext i8 %14 to i32, !dbg !64
  %16 = xor i32 %12, %15, !dbg !69
  call void @llvm.dbg.value(metadata i32 %16, metadata !54, metadata !DIExpression()), !dbg !57
  %17 = lshr i32 %16, 4, !dbg !70
  %18 = and i32 %16, 15, !dbg !71
  %19 = zext i32 %18 to i64, !dbg !72
  %20 = getelementptr inbounds [16 x i32], ptr @crc_of_nibble, i64 0, i64 %19, !dbg !72
  %21 = load i32, ptr %20, align 4, !dbg !72, !tbaa !73
  %22 = xor i32 %17, %21, !dbg !75
  call void @llvm.dbg.value(metadata i32 %22, metadata !54, metadata !DIExpression()), !dbg !57
  %23 = lshr i32 %22, 4, !dbg !76
  %24 = and i32 %22, 15, !dbg !77
  %25 = zext i32 %24 to i64, !dbg !78
  %26 = getelementptr inbounds [16 x i32], ptr @crc_of_nibble, i64 0, i64 %25, !dbg !78
  %27 = load i32, ptr %26, align 4, !dbg !78, !tbaa !73
  %28 = xor i32 %23, %27, !dbg !79
  call void @llvm.dbg.value(metadata i32 %28, metadata !54, metadata !DIExpression()), !dbg !57
  %29 = add nuw nsw i64 %11, 1, !dbg !80
  call void @llvm.dbg.value(metadata i64 %29, metadata !55, metadata !DIExpression()), !dbg !58
  %30 = icmp eq i64 %29, %5, !dbg !59
  br i1 %30, label %6, label %10, !dbg !61, !llvm.loop !81
}

; Function Attrs: mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare void @llvm.dbg.declare(metadata, metadata, metadata) #1

; Function Attrs: mustprogress nocallback nofree nosync nounwind willreturn memory(argmem: readwrite)
declare void @llvm.lifetime.start.p0(i64 immarg, ptr nocapture) #2

; Function Attrs: mustprogress nocallback nofree nosync nounwind willreturn memory(argmem: readwrite)
declare void @llvm.lifetime.end.p0(i64 immarg, ptr nocapture) #2

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @string_length(ptr nocapture noundef readonly %0) local_unnamed_addr #0 !dbg !85 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !90, metadata !DIExpression()), !dbg !92
  call void @llvm.dbg.value(metadata i32 0, metadata !91, metadata !DIExpression()), !dbg !92
  br label %2, !dbg !93

2:                                                ; preds = %2, %1
  %3 = phi i64 [ %7, %2 ], [ 0, %1 ], !dbg !92
  call void @llvm.dbg.value(metadata i64 %3, metadata !91, metadata !DIExpression()), !dbg !92
  %4 = getelementptr inbounds i8, ptr %0, i64 %3, !dbg !94
  %5 = load i8, ptr %4, align 1, !dbg !94, !tbaa !66
  %6 = icmp eq i8 %5, 0, !dbg !93
  %7 = add nuw i64 %3, 1, !dbg !95
  call void @llvm.dbg.value(metadata i64 %7, metadata !91, metadata !DIExpression()), !dbg !92
  br i1 %6, label %8, label %2, !dbg !93, !llvm.loop !96

8:                                                ; preds = %2
  %9 = trunc i64 %3 to i32, !dbg !97
  ret i32 %9, !dbg !97
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @find_byte(ptr nocapture noundef readonly %0, i32 noundef %1, i8 noundef zeroext %2) local_unnamed_addr #0 !dbg !98 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !102, metadata !DIExpression()), !dbg !107
  call void @llvm.dbg.value(metadata i32 %1, metadata !103, metadata !DIExpression()), !dbg !107
  call void @llvm.dbg.value(metadata i8 %2, metadata !104, metadata !DIExpression()), !dbg !107
  call void @llvm.dbg.value(metadata i32 0, metadata !105, metadata !DIExpression()), !dbg !108
  %4 = icmp sgt i32 %1, 0, !dbg !109
  br i1 %4, label %5, label %17, !dbg !111

5:                                                ; preds = %3
  %6 = zext i32 %1 to i64, !dbg !109
  br label %7, !dbg !111

7:                                                ; preds = %5, %12
  %8 = phi i64 [ 0, %5 ], [ %13, %12 ]
  call void @llvm.dbg.value(metadata i64 %8, metadata !105, metadata !DIExpression()), !dbg !108
  %9 = getelementptr inbounds i8, ptr %0, i64 %8, !dbg !112
  %10 = load i8, ptr %9, align 1, !dbg !112, !tbaa !66
  %11 = icmp eq i8 %10, %2, !dbg !114
  br i1 %11, label %15, label %12, !dbg !115

12:                                               ; preds = %7
  %13 = add nuw nsw i64 %8, 1, !dbg !116
  call void @llvm.dbg.value(metadata i64 %13, metadata !105, metadata !DIExpression()), !dbg !108
  %14 = icmp eq i64 %13, %6, !dbg !109
  br i1 %14, label %17, label %7, !dbg !111, !llvm.loop !117

15:                                               ; preds = %7
  %16 = trunc i64 %8 to i32, !dbg !115
  br label %17, !dbg !119

17:                                               ; preds = %15, %12, %3
  %18 = phi i32 [ -1, %3 ], [ %16, %15 ], [ -1, %12 ]
  ret i32 %18, !dbg !119
}

; Function Attrs: nofree nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @mix_pcm(ptr noalias nocapture noundef writeonly %0, ptr noalias nocapture noundef readonly %1, ptr noalias nocapture noundef readonly %2, i32 noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #3 !dbg !120 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !129, metadata !DIExpression()), !dbg !140
  call void @llvm.dbg.value(metadata ptr %1, metadata !130, metadata !DIExpression()), !dbg !140
  call void @llvm.dbg.value(metadata ptr %2, metadata !131, metadata !DIExpression()), !dbg !140
  call void @llvm.dbg.value(metadata i32 %3, metadata !132, metadata !DIExpression()), !dbg !140
  call void @llvm.dbg.value(metadata i32 %4, metadata !133, metadata !DIExpression()), !dbg !140
  call void @llvm.dbg.value(metadata i32 %5, metadata !134, metadata !DIExpression()), !dbg !140
  call void @llvm.dbg.value(metadata i32 0, metadata !135, metadata !DIExpression()), !dbg !141
  %7 = icmp sgt i32 %5, 0, !dbg !142
  br i1 %7, label %8, label %10, !dbg !143

8:                                                ; preds = %6
  %9 = zext i32 %5 to i64, !dbg !142
  br label %11, !dbg !143

10:                                               ; preds = %11, %6
  ret void, !dbg !144

11:                                               ; preds = %8, %11
  %12 = phi i64 [ 0, %8 ], [ %27, %11 ]
  call void @llvm.dbg.value(metadata i64 %12, metadata !135, metadata !DIExpression()), !dbg !141
  %13 = getelementptr inbounds i16, ptr %1, i64 %12, !dbg !145
  %14 = load i16, ptr %13, align 2, !dbg !145, !tbaa !146
  %15 = sext i16 %14 to i32, !dbg !145
  %16 = mul nsw i32 %15, %3, !dbg !148
  %17 = getelementptr inbounds i16, ptr %2, i64 %12, !dbg !149
  %18 = load i16, ptr %17, align 2, !dbg !149, !tbaa !146
  %19 = sext i16 %18 to i32, !dbg !149
  %20 = mul nsw i32 %19, %4, !dbg !150
  %21 = add nsw i32 %20, %16, !dbg !151
  %22 = ashr i32 %21, 8, !dbg !152
  call void @llvm.dbg.value(metadata i32 %22, metadata !137, metadata !DIExpression()), !dbg !153
  %23 = tail call i32 @llvm.smin.i32(i32 %22, i32 32767), !dbg !154
  call void @llvm.dbg.value(metadata i32 %23, metadata !137, metadata !DIExpression()), !dbg !153
  %24 = tail call i32 @llvm.smax.i32(i32 %23, i32 -32768), !dbg !155
  call void @llvm.dbg.value(metadata i32 %24, metadata !137, metadata !DIExpression()), !dbg !153
  %25 = trunc i32 %24 to i16, !dbg !156
  %26 = getelementptr inbounds i16, ptr %0, i64 %12, !dbg !157
  store i16 %25, ptr %26, align 2, !dbg !158, !tbaa !146
  %27 = add nuw nsw i64 %12, 1, !dbg !159
  call void @llvm.dbg.value(metadata i64 %27, metadata !135, metadata !DIExpression()), !dbg !141
  %28 = icmp eq i64 %27, %9, !dbg !142
  br i1 %28, label %10, label %11, !dbg !143, !llvm.loop !160
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i64 @fnv1a(ptr nocapture noundef readonly %0, i32 noundef %1, i64 noundef %2) local_unnamed_addr #0 !dbg !162 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !169, metadata !DIExpression()), !dbg !174
  call void @llvm.dbg.value(metadata i32 %1, metadata !170, metadata !DIExpression()), !dbg !174
  call void @llvm.dbg.value(metadata i64 %2, metadata !171, metadata !DIExpression()), !dbg !174
  call void @llvm.dbg.value(metadata i32 0, metadata !172, metadata !DIExpression()), !dbg !175
  %4 = icmp sgt i32 %1, 0, !dbg !176
  br i1 %4, label %5, label %7, !dbg !178

5:                                                ; preds = %3
  %6 = zext i32 %1 to i64, !dbg !176
  br label %9, !dbg !178

7:                                                ; preds = %9, %3
  %8 = phi i64 [ %2, %3 ], [ %16, %9 ]
  ret i64 %8, !dbg !179

9:                                                ; preds = %5, %9
  %10 = phi i64 [ 0, %5 ], [ %17, %9 ]
  %11 = phi i64 [ %2, %5 ], [ %16, %9 ]
  call void @llvm.dbg.value(metadata i64 %10, metadata !172, metadata !DIExpression()), !dbg !175
  call void @llvm.dbg.value(metadata i64 %11, metadata !171, metadata !DIExpression()), !dbg !174
  %12 = getelementptr inbounds i8, ptr %0, i64 %10, !dbg !180
  %13 = load i8, ptr %12, align 1, !dbg !180, !tbaa !66
  %14 = zext i8 %13 to i64, !dbg !180
  %15 = xor i64 %11, %14, !dbg !181
  %16 = mul i64 %15, 1099511628211, !dbg !182
  call void @llvm.dbg.value(metadata i64 %16, metadata !171, metadata !DIExpression()), !dbg !174
  %17 = add nuw nsw i64 %10, 1, !dbg !183
  call void @llvm.dbg.value(metadata i64 %17, metadata !172, metadata !DIExpression()), !dbg !175
  %18 = icmp eq i64 %17, %6, !dbg !176
  br i1 %18, label %7, label %9, !dbg !178, !llvm.loop !184
}

; Function Attrs: nofree norecurse nosync nounwind memory(none) uwtable
define dso_local i64 @xorshift64(i64 noundef %0, i32 noundef %1) local_unnamed_addr #4 !dbg !186 {
  call void @llvm.dbg.value(metadata i64 %0, metadata !190, metadata !DIExpression()), !dbg !194
  call void @llvm.dbg.value(metadata i32 %1, metadata !191, metadata !DIExpression()), !dbg !194
  call void @llvm.dbg.value(metadata i32 0, metadata !192, metadata !DIExpression()), !dbg !195
  %3 = icmp sgt i32 %1, 0, !dbg !196
  br i1 %3, label %6, label %4, !dbg !198

4:                                                ; preds = %6, %2
  %5 = phi i64 [ %0, %2 ], [ %14, %6 ]
  ret i64 %5, !dbg !199

6:                                                ; preds = %2, %6
  %7 = phi i32 [ %15, %6 ], [ 0, %2 ]
  %8 = phi i64 [ %14, %6 ], [ %0, %2 ]
  call void @llvm.dbg.value(metadata i32 %7, metadata !192, metadata !DIExpression()), !dbg !195
  call void @llvm.dbg.value(metadata i64 %8, metadata !190, metadata !DIExpression()), !dbg !194
  %9 = shl i64 %8, 13, !dbg !200
  %10 = xor i64 %9, %8, !dbg !202
  call void @llvm.dbg.value(metadata i64 %10, metadata !190, metadata !DIExpression()), !dbg !194
  %11 = lshr i64 %10, 7, !dbg !203
  %12 = xor i64 %11, %10, !dbg !204
  call void @llvm.dbg.value(metadata i64 %12, metadata !190, metadata !DIExpression()), !dbg !194
  %13 = shl i64 %12, 17, !dbg !205
  %14 = xor i64 %13, %12, !dbg !206
  call void @llvm.dbg.value(metadata i64 %14, metadata !190, metadata !DIExpression()), !dbg !194
  %15 = add nuw nsw i32 %7, 1, !dbg !207
  call void @llvm.dbg.value(metadata i32 %15, metadata !192, metadata !DIExpression()), !dbg !195
  %16 = icmp eq i32 %15, %1, !dbg !196
  br i1 %16, label %4, label %6, !dbg !198, !llvm.loop !208
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: write) uwtable
define dso_local i32 @digits(i32 noundef %0, i32 noundef %1, ptr nocapture noundef writeonly %2) local_unnamed_addr #5 !dbg !17 {
  call void @llvm.dbg.value(metadata i32 %0, metadata !26, metadata !DIExpression()), !dbg !210
  call void @llvm.dbg.value(metadata i32 %1, metadata !27, metadata !DIExpression()), !dbg !210
  call void @llvm.dbg.value(metadata ptr %2, metadata !28, metadata !DIExpression()), !dbg !210
  call void @llvm.dbg.value(metadata i32 0, metadata !29, metadata !DIExpression()), !dbg !210
  br label %4, !dbg !211

4:                                                ; preds = %4, %3
  %5 = phi i64 [ %11, %4 ], [ 0, %3 ]
  %6 = phi i32 [ %13, %4 ], [ %0, %3 ]
  call void @llvm.dbg.value(metadata i64 %5, metadata !29, metadata !DIExpression()), !dbg !210
  call void @llvm.dbg.value(metadata i32 %6, metadata !26, metadata !DIExpression()), !dbg !210
  %7 = urem i32 %6, %1, !dbg !212
  %8 = zext i32 %7 to i64, !dbg !214
  %9 = getelementptr inbounds [37 x i8], ptr @digits.letters, i64 0, i64 %8, !dbg !214
  %10 = load i8, ptr %9, align 1, !dbg !214, !tbaa !66
  %11 = add nuw i64 %5, 1, !dbg !215
  call void @llvm.dbg.value(metadata i64 %11, metadata !29, metadata !DIExpression()), !dbg !210
  %12 = getelementptr inbounds i8, ptr %2, i64 %5, !dbg !216
  store i8 %10, ptr %12, align 1, !dbg !217, !tbaa !66
  %13 = udiv i32 %6, %1, !dbg !218
  call void @llvm.dbg.value(metadata i32 %13, metadata !26, metadata !DIExpression()), !dbg !210
  %14 = icmp ult i32 %6, %1, !dbg !219
  br i1 %14, label %15, label %4, !dbg !219, !llvm.loop !220

15:                                               ; preds = %4
  %16 = trunc i64 %11 to i32, !dbg !222
  ret i32 %16, !dbg !222
}

; Function Attrs: nofree nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @counting_sort(ptr nocapture noundef readonly %0, ptr nocapture noundef writeonly %1, i32 noundef %2) local_unnamed_addr #3 !dbg !223 {
  %4 = alloca [65 x i32], align 16
  call void @llvm.dbg.value(metadata ptr %0, metadata !227, metadata !DIExpression()), !dbg !242
  call void @llvm.dbg.value(metadata ptr %1, metadata !228, metadata !DIExpression()), !dbg !242
  call void @llvm.dbg.value(metadata i32 %2, metadata !229, metadata !DIExpression()), !dbg !242
  call void @llvm.lifetime.start.p0(i64 260, ptr nonnull %4) #8, !dbg !243
  call void @llvm.dbg.declare(metadata ptr %4, metadata !230, metadata !DIExpression()), !dbg !244
  call void @llvm.memset.p0.i64(ptr noundef nonnull align 16 dereferenceable(260) %4, i8 0, i64 260, i1 false), !dbg !245
  call void @llvm.dbg.value(metadata i32 0, metadata !236, metadata !DIExpression()), !dbg !246
  %5 = icmp sgt i32 %2, 0, !dbg !247
  br i1 %5, label %6, label %8, !dbg !249

6:                                                ; preds = %3
  %7 = zext i32 %2 to i64, !dbg !247
  br label %10, !dbg !249

8:                                                ; preds = %10, %3
  call void @llvm.dbg.value(metadata i32 0, metadata !238, metadata !DIExpression()), !dbg !250
  %9 = load i32, ptr %4, align 16
  br label %26, !dbg !251

10:                                               ; preds = %6, %10
  %11 = phi i64 [ 0, %6 ], [ %20, %10 ]
  call void @llvm.dbg.value(metadata i64 %11, metadata !236, metadata !DIExpression()), !dbg !246
  %12 = getelementptr inbounds i8, ptr %0, i64 %11, !dbg !252
  %13 = load i8, ptr %12, align 1, !dbg !252, !tbaa !66
  %14 = and i8 %13, 63, !dbg !253
  %15 = add nuw nsw i8 %14, 1, !dbg !254
  %16 = zext i8 %15 to i64
  %17 = getelementptr inbounds [65 x i32], ptr %4, i64 0, i64 %16, !dbg !255
  %18 = load i32, ptr %17, align 4, !dbg !256, !tbaa !73
  %19 = add nsw i32 %18, 1, !dbg !256
  store i32 %19, ptr %17, align 4, !dbg !256, !tbaa !73
  %20 = add nuw nsw i64 %11, 1, !dbg !257
  call void @llvm.dbg.value(metadata i64 %20, metadata !236, metadata !DIExpression()), !dbg !246
  %21 = icmp eq i64 %20, %7, !dbg !247
  br i1 %21, label %8, label %10, !dbg !249, !llvm.loop !258

22:                                               ; preds = %26
  call void @llvm.dbg.value(metadata i32 0, metadata !240, metadata !DIExpression()), !dbg !260
  %23 = icmp sgt i32 %2, 0, !dbg !261
  br i1 %23, label %24, label %34, !dbg !263

24:                                               ; preds = %22
  %25 = zext i32 %2 to i64, !dbg !261
  br label %35, !dbg !263

26:                                               ; preds = %8, %26
  %27 = phi i32 [ %9, %8 ], [ %32, %26 ]
  %28 = phi i64 [ 0, %8 ], [ %29, %26 ]
  call void @llvm.dbg.value(metadata i64 %28, metadata !238, metadata !DIExpression()), !dbg !250
  %29 = add nuw nsw i64 %28, 1, !dbg !264
  %30 = getelementptr inbounds [65 x i32], ptr %4, i64 0, i64 %29, !dbg !266
  %31 = load i32, ptr %30, align 4, !dbg !267, !tbaa !73
  %32 = add nsw i32 %31, %27, !dbg !267
  store i32 %32, ptr %30, align 4, !dbg !267, !tbaa !73
  call void @llvm.dbg.value(metadata i64 %29, metadata !238, metadata !DIExpression()), !dbg !250
  %33 = icmp eq i64 %29, 64, !dbg !268
  br i1 %33, label %22, label %26, !dbg !251, !llvm.loop !269

34:                                               ; preds = %35, %22
  call void @llvm.lifetime.end.p0(i64 260, ptr nonnull %4) #8, !dbg !271
  ret void, !dbg !271

35:                                               ; preds = %24, %35
  %36 = phi i64 [ 0, %24 ], [ %46, %35 ]
  call void @llvm.dbg.value(metadata i64 %36, metadata !240, metadata !DIExpression()), !dbg !260
  %37 = getelementptr inbounds i8, ptr %0, i64 %36, !dbg !272
  %38 = load i8, ptr %37, align 1, !dbg !272, !tbaa !66
  %39 = and i8 %38, 63, !dbg !273
  %40 = zext i8 %39 to i64
  %41 = getelementptr inbounds [65 x i32], ptr %4, i64 0, i64 %40, !dbg !274
  %42 = load i32, ptr %41, align 4, !dbg !275, !tbaa !73
  %43 = add nsw i32 %42, 1, !dbg !275
  store i32 %43, ptr %41, align 4, !dbg !275, !tbaa !73
  %44 = sext i32 %42 to i64, !dbg !276
  %45 = getelementptr inbounds i8, ptr %1, i64 %44, !dbg !276
  store i8 %38, ptr %45, align 1, !dbg !277, !tbaa !66
  %46 = add nuw nsw i64 %36, 1, !dbg !278
  call void @llvm.dbg.value(metadata i64 %46, metadata !240, metadata !DIExpression()), !dbg !260
  %47 = icmp eq i64 %46, %25, !dbg !261
  br i1 %47, label %34, label %35, !dbg !263, !llvm.loop !279
}

; Function Attrs: mustprogress nocallback nofree nounwind willreturn memory(argmem: write)
declare void @llvm.memset.p0.i64(ptr nocapture writeonly, i8, i64, i1 immarg) #6

; Function Attrs: nofree nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @distinct_bytes(ptr nocapture noundef readonly %0, i32 noundef %1, ptr nocapture noundef writeonly %2) local_unnamed_addr #3 !dbg !281 {
  %4 = alloca [256 x i8], align 16
  call void @llvm.dbg.value(metadata ptr %0, metadata !287, metadata !DIExpression()), !dbg !299
  call void @llvm.dbg.value(metadata i32 %1, metadata !288, metadata !DIExpression()), !dbg !299
  call void @llvm.dbg.value(metadata ptr %2, metadata !289, metadata !DIExpression()), !dbg !299
  call void @llvm.lifetime.start.p0(i64 256, ptr nonnull %4) #8, !dbg !300
  call void @llvm.dbg.declare(metadata ptr %4, metadata !290, metadata !DIExpression()), !dbg !301
  call void @llvm.memset.p0.i64(ptr noundef nonnull align 16 dereferenceable(256) %4, i8 0, i64 256, i1 false), !dbg !302
  call void @llvm.dbg.value(metadata i32 0, metadata !294, metadata !DIExpression()), !dbg !303
  %5 = icmp sgt i32 %1, 0, !dbg !304
  br i1 %5, label %7, label %6, !dbg !306

6:                                                ; preds = %9, %3
  br label %18, !dbg !307

7:                                                ; preds = %3
  %8 = zext i32 %1 to i64, !dbg !304
  br label %9, !dbg !306

9:                                                ; preds = %7, %9
  %10 = phi i64 [ 0, %7 ], [ %15, %9 ]
  call void @llvm.dbg.value(metadata i64 %10, metadata !294, metadata !DIExpression()), !dbg !303
  %11 = getelementptr inbounds i8, ptr %0, i64 %10, !dbg !308
  %12 = load i8, ptr %11, align 1, !dbg !308, !tbaa !66
  %13 = zext i8 %12 to i64, !dbg !309
  %14 = getelementptr inbounds [256 x i8], ptr %4, i64 0, i64 %13, !dbg !309
  store i8 1, ptr %14, align 1, !dbg !310, !tbaa !66
  %15 = add nuw nsw i64 %10, 1, !dbg !311
  call void @llvm.dbg.value(metadata i64 %15, metadata !294, metadata !DIExpression()), !dbg !303
  %16 = icmp eq i64 %15, %8, !dbg !304
  br i1 %16, label %6, label %9, !dbg !306, !llvm.loop !312

17:                                               ; preds = %18
  call void @llvm.lifetime.end.p0(i64 256, ptr nonnull %4) #8, !dbg !314
  ret i32 %27, !dbg !315

18:                                               ; preds = %6, %18
  %19 = phi i64 [ %28, %18 ], [ 0, %6 ]
  %20 = phi i32 [ %27, %18 ], [ 0, %6 ]
  call void @llvm.dbg.value(metadata i64 %19, metadata !297, metadata !DIExpression()), !dbg !316
  call void @llvm.dbg.value(metadata i32 %20, metadata !296, metadata !DIExpression()), !dbg !299
  %21 = getelementptr inbounds [256 x i8], ptr %4, i64 0, i64 %19, !dbg !317
  %22 = load i8, ptr %21, align 1, !dbg !317, !tbaa !66
  %23 = icmp ne i8 %22, 0, !dbg !320
  %24 = getelementptr inbounds i8, ptr %2, i64 %19, !dbg !321
  %25 = zext i1 %23 to i8, !dbg !322
  store i8 %25, ptr %24, align 1, !dbg !322, !tbaa !323
  %26 = zext i8 %22 to i32, !dbg !325
  %27 = add nuw nsw i32 %20, %26, !dbg !326
  call void @llvm.dbg.value(metadata i32 %27, metadata !296, metadata !DIExpression()), !dbg !299
  %28 = add nuw nsw i64 %19, 1, !dbg !327
  call void @llvm.dbg.value(metadata i64 %28, metadata !297, metadata !DIExpression()), !dbg !316
  %29 = icmp eq i64 %28, 256, !dbg !328
  br i1 %29, label %17, label %18, !dbg !307, !llvm.loop !329
}

; Function Attrs: nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare void @llvm.dbg.value(metadata, metadata, metadata) #7

; Function Attrs: nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare i32 @llvm.smin.i32(i32, i32) #7

; Function Attrs: nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare i32 @llvm.smax.i32(i32, i32) #7

attributes #0 = { nofree norecurse nosync nounwind memory(argmem: read) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #1 = { mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none) }
attributes #2 = { mustprogress nocallback nofree nosync nounwind willreturn memory(argmem: readwrite) }
attributes #3 = { nofree nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #4 = { nofree norecurse nosync nounwind memory(none) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #5 = { nofree norecurse nosync nounwind memory(argmem: write) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #6 = { mustprogress nocallback nofree nounwind willreturn memory(argmem: write) }
attributes #7 = { nocallback nofree nosync nounwind speculatable willreturn memory(none) }
attributes #8 = { nounwind }

!llvm.dbg.cu = !{!2}
!llvm.module.flags = !{!39, !40, !41, !42, !43, !44}
!llvm.ident = !{!45}

!0 = !DIGlobalVariableExpression(var: !1, expr: !DIExpression())
!1 = distinct !DIGlobalVariable(name: "crc_of_nibble", scope: !2, file: !3, line: 8, type: !35, isLocal: true, isDefinition: true)
!2 = distinct !DICompileUnit(language: DW_LANG_C11, file: !3, producer: "Debian clang version 16.0.6 (15~deb12u1)", isOptimized: true, runtimeVersion: 0, emissionKind: FullDebug, retainedTypes: !4, globals: !14, splitDebugInlining: false, nameTableKind: None)
!3 = !DIFile(filename: "bytes.c", directory: ".", checksumkind: CSK_MD5, checksum: "526e2ef2676c22aa04e1a0194c93859f")
!4 = !{!5, !10}
!5 = !DIDerivedType(tag: DW_TAG_typedef, name: "int16_t", file: !6, line: 25, baseType: !7)
!6 = !DIFile(filename: "/usr/include/x86_64-linux-gnu/bits/stdint-intn.h", directory: "", checksumkind: CSK_MD5, checksum: "55bcbdc3159515ebd91d351a70d505f4")
!7 = !DIDerivedType(tag: DW_TAG_typedef, name: "__int16_t", file: !8, line: 39, baseType: !9)
!8 = !DIFile(filename: "/usr/include/x86_64-linux-gnu/bits/types.h", directory: "", checksumkind: CSK_MD5, checksum: "d108b5f93a74c50510d7d9bc0ab36df9")
!9 = !DIBasicType(name: "short", size: 16, encoding: DW_ATE_signed)
!10 = !DIDerivedType(tag: DW_TAG_typedef, name: "uint8_t", file: !11, line: 24, baseType: !12)
!11 = !DIFile(filename: "/usr/include/x86_64-linux-gnu/bits/stdint-uintn.h", directory: "", checksumkind: CSK_MD5, checksum: "2bf2ae53c58c01b1a1b9383b5195125c")
!12 = !DIDerivedType(tag: DW_TAG_typedef, name: "__uint8_t", file: !8, line: 38, baseType: !13)
!13 = !DIBasicType(name: "unsigned char", size: 8, encoding: DW_ATE_unsigned_char)
!14 = !{!15, !0}
!15 = !DIGlobalVariableExpression(var: !16, expr: !DIExpression())
!16 = distinct !DIGlobalVariable(name: "letters", scope: !17, file: !3, line: 79, type: !30, isLocal: true, isDefinition: true)
!17 = distinct !DISubprogram(name: "digits", scope: !3, file: !3, line: 77, type: !18, scopeLine: 78, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !2, retainedNodes: !25)
!18 = !DISubroutineType(types: !19)
!19 = !{!20, !21, !21, !24}
!20 = !DIBasicType(name: "int", size: 32, encoding: DW_ATE_signed)
!21 = !DIDerivedType(tag: DW_TAG_typedef, name: "uint32_t", file: !11, line: 26, baseType: !22)
!22 = !DIDerivedType(tag: DW_TAG_typedef, name: "__uint32_t", file: !8, line: 42, baseType: !23)
!23 = !DIBasicType(name: "unsigned int", size: 32, encoding: DW_ATE_unsigned)
!24 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !10, size: 64)
!25 = !{!26, !27, !28, !29}
!26 = !DILocalVariable(name: "number", arg: 1, scope: !17, file: !3, line: 77, type: !21)
!27 = !DILocalVariable(name: "base", arg: 2, scope: !17, file: !3, line: 77, type: !21)
!28 = !DILocalVariable(name: "out", arg: 3, scope: !17, file: !3, line: 77, type: !24)
!29 = !DILocalVariable(name: "n", scope: !17, file: !3, line: 80, type: !20)
!30 = !DICompositeType(tag: DW_TAG_array_type, baseType: !31, size: 296, elements: !33)
!31 = !DIDerivedType(tag: DW_TAG_const_type, baseType: !32)
!32 = !DIBasicType(name: "char", size: 8, encoding: DW_ATE_signed_char)
!33 = !{!34}
!34 = !DISubrange(count: 37)
!35 = !DICompositeType(tag: DW_TAG_array_type, baseType: !36, size: 512, elements: !37)
!36 = !DIDerivedType(tag: DW_TAG_const_type, baseType: !21)
!37 = !{!38}
!38 = !DISubrange(count: 16)
!39 = !{i32 7, !"Dwarf Version", i32 5}
!40 = !{i32 2, !"Debug Info Version", i32 3}
!41 = !{i32 1, !"wchar_size", i32 4}
!42 = !{i32 8, !"PIC Level", i32 2}
!43 = !{i32 7, !"PIE Level", i32 2}
!44 = !{i32 7, !"uwtable", i32 2}
!45 = !{!"Debian clang version 16.0.6 (15~deb12u1)"}
!46 = distinct !DISubprogram(name: "crc32_table", scope: !3, file: !3, line: 14, type: !47, scopeLine: 15, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !2, retainedNodes: !51)
!47 = !DISubroutineType(types: !48)
!48 = !{!21, !49, !20}
!49 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !50, size: 64)
!50 = !DIDerivedType(tag: DW_TAG_const_type, baseType: !10)
!51 = !{!52, !53, !54, !55}
!52 = !DILocalVariable(name: "data", arg: 1, scope: !46, file: !3, line: 14, type: !49)
!53 = !DILocalVariable(name: "n", arg: 2, scope: !46, file: !3, line: 14, type: !20)
!54 = !DILocalVariable(name: "crc", scope: !46, file: !3, line: 16, type: !21)
!55 = !DILocalVariable(name: "i", scope: !56, file: !3, line: 17, type: !20)
!56 = distinct !DILexicalBlock(scope: !46, file: !3, line: 17, column: 5)
!57 = !DILocation(line: 0, scope: !46)
!58 = !DILocation(line: 0, scope: !56)
!59 = !DILocation(line: 17, column: 23, scope: !60)
!60 = distinct !DILexicalBlock(scope: !56, file: !3, line: 17, column: 5)
!61 = !DILocation(line: 17, column: 5, scope: !56)
!62 = !DILocation(line: 22, column: 12, scope: !46)
!63 = !DILocation(line: 22, column: 5, scope: !46)
!64 = !DILocation(line: 18, column: 16, scope: !65)
!65 = distinct !DILexicalBlock(scope: !60, file: !3, line: 17, column: 33)
!66 = !{!67, !67, i64 0}
!67 = !{!"omnipotent char", !68, i64 0}
!68 = !{!"Simple C/C++ TBAA"}
!69 = !DILocation(line: 18, column: 13, scope: !65)
!70 = !DILocation(line: 19, column: 19, scope: !65)
!71 = !DILocation(line: 19, column: 44, scope: !65)
!72 = !DILocation(line: 19, column: 26, scope: !65)
!73 = !{!74, !74, i64 0}
!74 = !{!"int", !67, i64 0}
!75 = !DILocation(line: 19, column: 24, scope: !65)
!76 = !DILocation(line: 20, column: 19, scope: !65)
!77 = !DILocation(line: 20, column: 44, scope: !65)
!78 = !DILocation(line: 20, column: 26, scope: !65)
!79 = !DILocation(line: 20, column: 24, scope: !65)
!80 = !DILocation(line: 17, column: 29, scope: !60)
!81 = distinct !{!81, !61, !82, !83, !84}
!82 = !DILocation(line: 21, column: 5, scope: !56)
!83 = !{!"llvm.loop.mustprogress"}
!84 = !{!"llvm.loop.unroll.disable"}
!85 = distinct !DISubprogram(name: "string_length", scope: !3, file: !3, line: 26, type: !86, scopeLine: 27, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !2, retainedNodes: !89)
!86 = !DISubroutineType(types: !87)
!87 = !{!20, !88}
!88 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !31, size: 64)
!89 = !{!90, !91}
!90 = !DILocalVariable(name: "text", arg: 1, scope: !85, file: !3, line: 26, type: !88)
!91 = !DILocalVariable(name: "n", scope: !85, file: !3, line: 28, type: !20)
!92 = !DILocation(line: 0, scope: !85)
!93 = !DILocation(line: 29, column: 5, scope: !85)
!94 = !DILocation(line: 29, column: 12, scope: !85)
!95 = !DILocation(line: 30, column: 10, scope: !85)
!96 = distinct !{!96, !93, !95, !83, !84}
!97 = !DILocation(line: 31, column: 5, scope: !85)
!98 = distinct !DISubprogram(name: "find_byte", scope: !3, file: !3, line: 35, type: !99, scopeLine: 36, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !2, retainedNodes: !101)
!99 = !DISubroutineType(types: !100)
!100 = !{!20, !49, !20, !10}
!101 = !{!102, !103, !104, !105}
!102 = !DILocalVariable(name: "data", arg: 1, scope: !98, file: !3, line: 35, type: !49)
!103 = !DILocalVariable(name: "n", arg: 2, scope: !98, file: !3, line: 35, type: !20)
!104 = !DILocalVariable(name: "wanted", arg: 3, scope: !98, file: !3, line: 35, type: !10)
!105 = !DILocalVariable(name: "i", scope: !106, file: !3, line: 37, type: !20)
!106 = distinct !DILexicalBlock(scope: !98, file: !3, line: 37, column: 5)
!107 = !DILocation(line: 0, scope: !98)
!108 = !DILocation(line: 0, scope: !106)
!109 = !DILocation(line: 37, column: 23, scope: !110)
!110 = distinct !DILexicalBlock(scope: !106, file: !3, line: 37, column: 5)
!111 = !DILocation(line: 37, column: 5, scope: !106)
!112 = !DILocation(line: 38, column: 13, scope: !113)
!113 = distinct !DILexicalBlock(scope: !110, file: !3, line: 38, column: 13)
!114 = !DILocation(line: 38, column: 21, scope: !113)
!115 = !DILocation(line: 38, column: 13, scope: !110)
!116 = !DILocation(line: 37, column: 29, scope: !110)
!117 = distinct !{!117, !111, !118, !83, !84}
!118 = !DILocation(line: 39, column: 20, scope: !106)
!119 = !DILocation(line: 41, column: 1, scope: !98)
!120 = distinct !DISubprogram(name: "mix_pcm", scope: !3, file: !3, line: 44, type: !121, scopeLine: 46, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !2, retainedNodes: !128)
!121 = !DISubroutineType(types: !122)
!122 = !{null, !123, !125, !125, !20, !20, !20}
!123 = !DIDerivedType(tag: DW_TAG_restrict_type, baseType: !124)
!124 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !5, size: 64)
!125 = !DIDerivedType(tag: DW_TAG_restrict_type, baseType: !126)
!126 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !127, size: 64)
!127 = !DIDerivedType(tag: DW_TAG_const_type, baseType: !5)
!128 = !{!129, !130, !131, !132, !133, !134, !135, !137}
!129 = !DILocalVariable(name: "out", arg: 1, scope: !120, file: !3, line: 44, type: !123)
!130 = !DILocalVariable(name: "a", arg: 2, scope: !120, file: !3, line: 44, type: !125)
!131 = !DILocalVariable(name: "b", arg: 3, scope: !120, file: !3, line: 44, type: !125)
!132 = !DILocalVariable(name: "gain_a", arg: 4, scope: !120, file: !3, line: 45, type: !20)
!133 = !DILocalVariable(name: "gain_b", arg: 5, scope: !120, file: !3, line: 45, type: !20)
!134 = !DILocalVariable(name: "n", arg: 6, scope: !120, file: !3, line: 45, type: !20)
!135 = !DILocalVariable(name: "i", scope: !136, file: !3, line: 47, type: !20)
!136 = distinct !DILexicalBlock(scope: !120, file: !3, line: 47, column: 5)
!137 = !DILocalVariable(name: "mixed", scope: !138, file: !3, line: 48, type: !20)
!138 = distinct !DILexicalBlock(scope: !139, file: !3, line: 47, column: 33)
!139 = distinct !DILexicalBlock(scope: !136, file: !3, line: 47, column: 5)
!140 = !DILocation(line: 0, scope: !120)
!141 = !DILocation(line: 0, scope: !136)
!142 = !DILocation(line: 47, column: 23, scope: !139)
!143 = !DILocation(line: 47, column: 5, scope: !136)
!144 = !DILocation(line: 55, column: 1, scope: !120)
!145 = !DILocation(line: 48, column: 22, scope: !138)
!146 = !{!147, !147, i64 0}
!147 = !{!"short", !67, i64 0}
!148 = !DILocation(line: 48, column: 27, scope: !138)
!149 = !DILocation(line: 48, column: 38, scope: !138)
!150 = !DILocation(line: 48, column: 43, scope: !138)
!151 = !DILocation(line: 48, column: 36, scope: !138)
!152 = !DILocation(line: 48, column: 53, scope: !138)
!153 = !DILocation(line: 0, scope: !138)
!154 = !DILocation(line: 49, column: 13, scope: !138)
!155 = !DILocation(line: 51, column: 13, scope: !138)
!156 = !DILocation(line: 53, column: 18, scope: !138)
!157 = !DILocation(line: 53, column: 9, scope: !138)
!158 = !DILocation(line: 53, column: 16, scope: !138)
!159 = !DILocation(line: 47, column: 29, scope: !139)
!160 = distinct !{!160, !143, !161, !83, !84}
!161 = !DILocation(line: 54, column: 5, scope: !136)
!162 = distinct !DISubprogram(name: "fnv1a", scope: !3, file: !3, line: 58, type: !163, scopeLine: 59, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !2, retainedNodes: !168)
!163 = !DISubroutineType(types: !164)
!164 = !{!165, !49, !20, !165}
!165 = !DIDerivedType(tag: DW_TAG_typedef, name: "uint64_t", file: !11, line: 27, baseType: !166)
!166 = !DIDerivedType(tag: DW_TAG_typedef, name: "__uint64_t", file: !8, line: 45, baseType: !167)
!167 = !DIBasicType(name: "unsigned long", size: 64, encoding: DW_ATE_unsigned)
!168 = !{!169, !170, !171, !172}
!169 = !DILocalVariable(name: "data", arg: 1, scope: !162, file: !3, line: 58, type: !49)
!170 = !DILocalVariable(name: "n", arg: 2, scope: !162, file: !3, line: 58, type: !20)
!171 = !DILocalVariable(name: "hash", arg: 3, scope: !162, file: !3, line: 58, type: !165)
!172 = !DILocalVariable(name: "i", scope: !173, file: !3, line: 60, type: !20)
!173 = distinct !DILexicalBlock(scope: !162, file: !3, line: 60, column: 5)
!174 = !DILocation(line: 0, scope: !162)
!175 = !DILocation(line: 0, scope: !173)
!176 = !DILocation(line: 60, column: 23, scope: !177)
!177 = distinct !DILexicalBlock(scope: !173, file: !3, line: 60, column: 5)
!178 = !DILocation(line: 60, column: 5, scope: !173)
!179 = !DILocation(line: 62, column: 5, scope: !162)
!180 = !DILocation(line: 61, column: 24, scope: !177)
!181 = !DILocation(line: 61, column: 22, scope: !177)
!182 = !DILocation(line: 61, column: 33, scope: !177)
!183 = !DILocation(line: 60, column: 29, scope: !177)
!184 = distinct !{!184, !178, !185, !83, !84}
!185 = !DILocation(line: 61, column: 35, scope: !173)
!186 = distinct !DISubprogram(name: "xorshift64", scope: !3, file: !3, line: 66, type: !187, scopeLine: 67, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !2, retainedNodes: !189)
!187 = !DISubroutineType(types: !188)
!188 = !{!165, !165, !20}
!189 = !{!190, !191, !192}
!190 = !DILocalVariable(name: "state", arg: 1, scope: !186, file: !3, line: 66, type: !165)
!191 = !DILocalVariable(name: "n", arg: 2, scope: !186, file: !3, line: 66, type: !20)
!192 = !DILocalVariable(name: "i", scope: !193, file: !3, line: 68, type: !20)
!193 = distinct !DILexicalBlock(scope: !186, file: !3, line: 68, column: 5)
!194 = !DILocation(line: 0, scope: !186)
!195 = !DILocation(line: 0, scope: !193)
!196 = !DILocation(line: 68, column: 23, scope: !197)
!197 = distinct !DILexicalBlock(scope: !193, file: !3, line: 68, column: 5)
!198 = !DILocation(line: 68, column: 5, scope: !193)
!199 = !DILocation(line: 73, column: 5, scope: !186)
!200 = !DILocation(line: 69, column: 24, scope: !201)
!201 = distinct !DILexicalBlock(scope: !197, file: !3, line: 68, column: 33)
!202 = !DILocation(line: 69, column: 15, scope: !201)
!203 = !DILocation(line: 70, column: 24, scope: !201)
!204 = !DILocation(line: 70, column: 15, scope: !201)
!205 = !DILocation(line: 71, column: 24, scope: !201)
!206 = !DILocation(line: 71, column: 15, scope: !201)
!207 = !DILocation(line: 68, column: 29, scope: !197)
!208 = distinct !{!208, !198, !209, !83, !84}
!209 = !DILocation(line: 72, column: 5, scope: !193)
!210 = !DILocation(line: 0, scope: !17)
!211 = !DILocation(line: 81, column: 5, scope: !17)
!212 = !DILocation(line: 82, column: 44, scope: !213)
!213 = distinct !DILexicalBlock(scope: !17, file: !3, line: 81, column: 8)
!214 = !DILocation(line: 82, column: 29, scope: !213)
!215 = !DILocation(line: 82, column: 14, scope: !213)
!216 = !DILocation(line: 82, column: 9, scope: !213)
!217 = !DILocation(line: 82, column: 18, scope: !213)
!218 = !DILocation(line: 83, column: 16, scope: !213)
!219 = !DILocation(line: 84, column: 5, scope: !213)
!220 = distinct !{!220, !211, !221, !83, !84}
!221 = !DILocation(line: 84, column: 20, scope: !17)
!222 = !DILocation(line: 85, column: 5, scope: !17)
!223 = distinct !DISubprogram(name: "counting_sort", scope: !3, file: !3, line: 89, type: !224, scopeLine: 90, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !2, retainedNodes: !226)
!224 = !DISubroutineType(types: !225)
!225 = !{null, !49, !24, !20}
!226 = !{!227, !228, !229, !230, !236, !238, !240}
!227 = !DILocalVariable(name: "data", arg: 1, scope: !223, file: !3, line: 89, type: !49)
!228 = !DILocalVariable(name: "sorted", arg: 2, scope: !223, file: !3, line: 89, type: !24)
!229 = !DILocalVariable(name: "n", arg: 3, scope: !223, file: !3, line: 89, type: !20)
!230 = !DILocalVariable(name: "starts", scope: !223, file: !3, line: 91, type: !231)
!231 = !DICompositeType(tag: DW_TAG_array_type, baseType: !232, size: 2080, elements: !234)
!232 = !DIDerivedType(tag: DW_TAG_typedef, name: "int32_t", file: !6, line: 26, baseType: !233)
!233 = !DIDerivedType(tag: DW_TAG_typedef, name: "__int32_t", file: !8, line: 41, baseType: !20)
!234 = !{!235}
!235 = !DISubrange(count: 65)
!236 = !DILocalVariable(name: "i", scope: !237, file: !3, line: 93, type: !20)
!237 = distinct !DILexicalBlock(scope: !223, file: !3, line: 93, column: 5)
!238 = !DILocalVariable(name: "i", scope: !239, file: !3, line: 95, type: !20)
!239 = distinct !DILexicalBlock(scope: !223, file: !3, line: 95, column: 5)
!240 = !DILocalVariable(name: "i", scope: !241, file: !3, line: 97, type: !20)
!241 = distinct !DILexicalBlock(scope: !223, file: !3, line: 97, column: 5)
!242 = !DILocation(line: 0, scope: !223)
!243 = !DILocation(line: 91, column: 5, scope: !223)
!244 = !DILocation(line: 91, column: 13, scope: !223)
!245 = !DILocation(line: 92, column: 5, scope: !223)
!246 = !DILocation(line: 0, scope: !237)
!247 = !DILocation(line: 93, column: 23, scope: !248)
!248 = distinct !DILexicalBlock(scope: !237, file: !3, line: 93, column: 5)
!249 = !DILocation(line: 93, column: 5, scope: !237)
!250 = !DILocation(line: 0, scope: !239)
!251 = !DILocation(line: 95, column: 5, scope: !239)
!252 = !DILocation(line: 94, column: 17, scope: !248)
!253 = !DILocation(line: 94, column: 25, scope: !248)
!254 = !DILocation(line: 94, column: 31, scope: !248)
!255 = !DILocation(line: 94, column: 9, scope: !248)
!256 = !DILocation(line: 94, column: 35, scope: !248)
!257 = !DILocation(line: 93, column: 29, scope: !248)
!258 = distinct !{!258, !249, !259, !83, !84}
!259 = !DILocation(line: 94, column: 35, scope: !237)
!260 = !DILocation(line: 0, scope: !241)
!261 = !DILocation(line: 97, column: 23, scope: !262)
!262 = distinct !DILexicalBlock(scope: !241, file: !3, line: 97, column: 5)
!263 = !DILocation(line: 97, column: 5, scope: !241)
!264 = !DILocation(line: 96, column: 18, scope: !265)
!265 = distinct !DILexicalBlock(scope: !239, file: !3, line: 95, column: 5)
!266 = !DILocation(line: 96, column: 9, scope: !265)
!267 = !DILocation(line: 96, column: 23, scope: !265)
!268 = !DILocation(line: 95, column: 23, scope: !265)
!269 = distinct !{!269, !251, !270, !83, !84}
!270 = !DILocation(line: 96, column: 34, scope: !239)
!271 = !DILocation(line: 99, column: 1, scope: !223)
!272 = !DILocation(line: 98, column: 42, scope: !262)
!273 = !DILocation(line: 98, column: 31, scope: !262)
!274 = !DILocation(line: 98, column: 16, scope: !262)
!275 = !DILocation(line: 98, column: 36, scope: !262)
!276 = !DILocation(line: 98, column: 9, scope: !262)
!277 = !DILocation(line: 98, column: 40, scope: !262)
!278 = !DILocation(line: 97, column: 29, scope: !262)
!279 = distinct !{!279, !263, !280, !83, !84}
!280 = !DILocation(line: 98, column: 48, scope: !241)
!281 = distinct !DISubprogram(name: "distinct_bytes", scope: !3, file: !3, line: 102, type: !282, scopeLine: 103, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !2, retainedNodes: !286)
!282 = !DISubroutineType(types: !283)
!283 = !{!20, !49, !20, !284}
!284 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !285, size: 64)
!285 = !DIBasicType(name: "_Bool", size: 8, encoding: DW_ATE_boolean)
!286 = !{!287, !288, !289, !290, !294, !296, !297}
!287 = !DILocalVariable(name: "text", arg: 1, scope: !281, file: !3, line: 102, type: !49)
!288 = !DILocalVariable(name: "n", arg: 2, scope: !281, file: !3, line: 102, type: !20)
!289 = !DILocalVariable(name: "occurs", arg: 3, scope: !281, file: !3, line: 102, type: !284)
!290 = !DILocalVariable(name: "seen", scope: !281, file: !3, line: 104, type: !291)
!291 = !DICompositeType(tag: DW_TAG_array_type, baseType: !10, size: 2048, elements: !292)
!292 = !{!293}
!293 = !DISubrange(count: 256)
!294 = !DILocalVariable(name: "i", scope: !295, file: !3, line: 106, type: !20)
!295 = distinct !DILexicalBlock(scope: !281, file: !3, line: 106, column: 5)
!296 = !DILocalVariable(name: "count", scope: !281, file: !3, line: 108, type: !20)
!297 = !DILocalVariable(name: "i", scope: !298, file: !3, line: 109, type: !20)
!298 = distinct !DILexicalBlock(scope: !281, file: !3, line: 109, column: 5)
!299 = !DILocation(line: 0, scope: !281)
!300 = !DILocation(line: 104, column: 5, scope: !281)
!301 = !DILocation(line: 104, column: 13, scope: !281)
!302 = !DILocation(line: 105, column: 5, scope: !281)
!303 = !DILocation(line: 0, scope: !295)
!304 = !DILocation(line: 106, column: 23, scope: !305)
!305 = distinct !DILexicalBlock(scope: !295, file: !3, line: 106, column: 5)
!306 = !DILocation(line: 106, column: 5, scope: !295)
!307 = !DILocation(line: 109, column: 5, scope: !298)
!308 = !DILocation(line: 107, column: 14, scope: !305)
!309 = !DILocation(line: 107, column: 9, scope: !305)
!310 = !DILocation(line: 107, column: 23, scope: !305)
!311 = !DILocation(line: 106, column: 29, scope: !305)
!312 = distinct !{!312, !306, !313, !83, !84}
!313 = !DILocation(line: 107, column: 25, scope: !295)
!314 = !DILocation(line: 114, column: 1, scope: !281)
!315 = !DILocation(line: 113, column: 5, scope: !281)
!316 = !DILocation(line: 0, scope: !298)
!317 = !DILocation(line: 110, column: 21, scope: !318)
!318 = distinct !DILexicalBlock(scope: !319, file: !3, line: 109, column: 35)
!319 = distinct !DILexicalBlock(scope: !298, file: !3, line: 109, column: 5)
!320 = !DILocation(line: 110, column: 29, scope: !318)
!321 = !DILocation(line: 110, column: 9, scope: !318)
!322 = !DILocation(line: 110, column: 19, scope: !318)
!323 = !{!324, !324, i64 0}
!324 = !{!"_Bool", !67, i64 0}
!325 = !DILocation(line: 111, column: 18, scope: !318)
!326 = !DILocation(line: 111, column: 15, scope: !318)
!327 = !DILocation(line: 109, column: 31, scope: !319)
!328 = !DILocation(line: 109, column: 23, scope: !319)
!329 = distinct !{!329, !307, !330, !83, !84}
!330 = !DILocation(line: 112, column: 5, scope: !298)
