; ModuleID = 'integers.c'
source_filename = "integers.c"
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"
target triple = "x86_64-pc-linux-gnu"

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @crc32(ptr nocapture noundef readonly %0, i32 noundef %1) local_unnamed_addr #0 !dbg !9 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !21, metadata !DIExpression()), !dbg !30
  call void @llvm.dbg.value(metadata i32 %1, metadata !22, metadata !DIExpression()), !dbg !30
  call void @llvm.dbg.value(metadata i32 -1, metadata !23, metadata !DIExpression()), !dbg !30
  call void @llvm.dbg.value(metadata i32 0, metadata !24, metadata !DIExpression()), !dbg !31
  %3 = icmp sgt i32 %1, 0, !dbg !32
  br i1 %3, label %4, label %8, !dbg !33

4:                                                ; preds = %2
  %5 = zext i32 %1 to i64, !dbg !32
  br label %10, !dbg !33

6:                                                ; preds = %16
  %7 = xor i32 %26, -1, !dbg !34
  br label %8, !dbg !34

8:                                                ; preds = %6, %2
  %9 = phi i32 [ 0, %2 ], [ %7, %6 ]
  ret i32 %9, !dbg !35

10:                                               ; preds = %4, %16
  %11 = phi i64 [ 0, %4 ], [ %17, %16 ]
  %12 = phi i32 [ -1, %4 ], [ %26, %16 ]
  call void @llvm.dbg.value(metadata i64 %11, metadata !24, metadata !DIExpression()), !dbg !31
  call void @llvm.dbg.value(metadata i32 %12, metadata !23, metadata !DIExpression()), !dbg !30
  %13 = getelementptr inbounds i32, ptr %0, i64 %11, !dbg !36
  %14 = load i32, ptr %13, align 4, !dbg !36, !tbaa !37
  %15 = xor i32 %14, %12, !dbg !41
  call void @llvm.dbg.value(metadata i32 %15, metadata !23, metadata !DIExpression()), !dbg !30
  call void @llvm.dbg.value(metadata i32 0, metadata !26, metadata !DIExpression()), !dbg !42
  br label %19, !dbg !43

16:                                               ; preds = %19
  %17 = add nuw nsw i64 %11, 1, !dbg !44
  call void @llvm.dbg.value(metadata i64 %17, metadata !24, metadata !DIExpression()), !dbg !31
  call void @llvm.dbg.value(metadata i32 %26, metadata !23, metadata !DIExpression()), !dbg !30
  %18 = icmp eq i64 %17, %5, !dbg !32
  br i1 %18, label %6, label %10, !dbg !33, !llvm.loop !45

19:                                               ; preds = %10, %19
  %20 = phi i32 [ 0, %10 ], [ %27, %19 ]
  %21 = phi i32 [ %15, %10 ], [ %26, %19 ]
  call void @llvm.dbg.value(metadata i32 %20, metadata !26, metadata !DIExpression()), !dbg !42
  call void @llvm.dbg.value(metadata i32 %21, metadata !23, metadata !DIExpression()), !dbg !30
  %22 = and i32 %21, 1, !dbg !49
  %23 = icmp eq i32 %22, 0, !dbg !49
  %24 = lshr i32 %21, 1, !dbg !51
  %25 = xor i32 %24, -306674912, !dbg !51
  %26 = select i1 %23, i32 %24, i32 %25, !dbg !51
  call void @llvm.dbg.value(metadata i32 %26, metadata !23, metadata !DIExpression()), !dbg !30
  %27 = add nuw nsw i32 %20, 1, !dbg !52
  call void @llvm.dbg.value(metadata i32 %27, metadata !26, metadata !DIExpression()), !dbg !42
  %28 = icmp eq i32 %27, 32, !dbg !53
  br i1 %28, label %16, label %19, !dbg !43, !llvm.loop !54
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @sha256_schedule(ptr nocapture noundef %0) local_unnamed_addr #1 !dbg !56 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !61, metadata !DIExpression()), !dbg !70
  call void @llvm.dbg.value(metadata i32 16, metadata !62, metadata !DIExpression()), !dbg !71
  br label %3, !dbg !72

2:                                                ; preds = %3
  ret void, !dbg !73

3:                                                ; preds = %1, %3
  %4 = phi i64 [ 16, %1 ], [ %31, %3 ]
  call void @llvm.dbg.value(metadata i64 %4, metadata !62, metadata !DIExpression()), !dbg !71
  %5 = add nsw i64 %4, -15, !dbg !74
  %6 = getelementptr inbounds i32, ptr %0, i64 %5, !dbg !75
  %7 = load i32, ptr %6, align 4, !dbg !75, !tbaa !37
  call void @llvm.dbg.value(metadata i32 %7, metadata !64, metadata !DIExpression()), !dbg !76
  %8 = add nsw i64 %4, -2, !dbg !77
  %9 = getelementptr inbounds i32, ptr %0, i64 %8, !dbg !78
  %10 = load i32, ptr %9, align 4, !dbg !78, !tbaa !37
  call void @llvm.dbg.value(metadata i32 %10, metadata !67, metadata !DIExpression()), !dbg !76
  call void @llvm.dbg.value(metadata i32 %7, metadata !79, metadata !DIExpression()), !dbg !85
  call void @llvm.dbg.value(metadata i32 7, metadata !84, metadata !DIExpression()), !dbg !85
  %11 = tail call i32 @llvm.fshl.i32(i32 %7, i32 %7, i32 25), !dbg !87
  call void @llvm.dbg.value(metadata i32 %7, metadata !79, metadata !DIExpression()), !dbg !88
  call void @llvm.dbg.value(metadata i32 18, metadata !84, metadata !DIExpression()), !dbg !88
  %12 = tail call i32 @llvm.fshl.i32(i32 %7, i32 %7, i32 14), !dbg !90
  %13 = xor i32 %11, %12, !dbg !91
  %14 = lshr i32 %7, 3, !dbg !92
  %15 = xor i32 %13, %14, !dbg !93
  call void @llvm.dbg.value(metadata i32 %15, metadata !68, metadata !DIExpression()), !dbg !76
  call void @llvm.dbg.value(metadata i32 %10, metadata !79, metadata !DIExpression()), !dbg !94
  call void @llvm.dbg.value(metadata i32 17, metadata !84, metadata !DIExpression()), !dbg !94
  %16 = tail call i32 @llvm.fshl.i32(i32 %10, i32 %10, i32 15), !dbg !96
  call void @llvm.dbg.value(metadata i32 %10, metadata !79, metadata !DIExpression()), !dbg !97
  call void @llvm.dbg.value(metadata i32 19, metadata !84, metadata !DIExpression()), !dbg !97
  %17 = tail call i32 @llvm.fshl.i32(i32 %10, i32 %10, i32 13), !dbg !99
  %18 = xor i32 %16, %17, !dbg !100
  %19 = lshr i32 %10, 10, !dbg !101
  %20 = xor i32 %18, %19, !dbg !102
  call void @llvm.dbg.value(metadata i32 %20, metadata !69, metadata !DIExpression()), !dbg !76
  %21 = add nsw i64 %4, -16, !dbg !103
  %22 = getelementptr inbounds i32, ptr %0, i64 %21, !dbg !104
  %23 = load i32, ptr %22, align 4, !dbg !104, !tbaa !37
  %24 = add i32 %15, %23, !dbg !105
  %25 = add nsw i64 %4, -7, !dbg !106
  %26 = getelementptr inbounds i32, ptr %0, i64 %25, !dbg !107
  %27 = load i32, ptr %26, align 4, !dbg !107, !tbaa !37
  %28 = add i32 %24, %27, !dbg !108
  %29 = add i32 %28, %20, !dbg !109
  %30 = getelementptr inbounds i32, ptr %0, i64 %4, !dbg !110
  store i32 %29, ptr %30, align 4, !dbg !111, !tbaa !37
  %31 = add nuw nsw i64 %4, 1, !dbg !112
  call void @llvm.dbg.value(metadata i64 %31, metadata !62, metadata !DIExpression()), !dbg !71
  %32 = icmp eq i64 %31, 64, !dbg !113
  br i1 %32, label %2, label %3, !dbg !72, !llvm.loop !114
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @sha256_rounds(ptr nocapture noundef %0, ptr nocapture noundef readonly %1, ptr nocapture noundef readonly %2) local_unnamed_addr #1 !dbg !116 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !120, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata ptr %1, metadata !121, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata ptr %2, metadata !122, metadata !DIExpression()), !dbg !139
  %4 = load i32, ptr %0, align 4, !dbg !140, !tbaa !37
  call void @llvm.dbg.value(metadata i32 %4, metadata !123, metadata !DIExpression()), !dbg !139
  %5 = getelementptr inbounds i32, ptr %0, i64 1, !dbg !141
  %6 = load i32, ptr %5, align 4, !dbg !141, !tbaa !37
  call void @llvm.dbg.value(metadata i32 %6, metadata !124, metadata !DIExpression()), !dbg !139
  %7 = getelementptr inbounds i32, ptr %0, i64 2, !dbg !142
  %8 = load i32, ptr %7, align 4, !dbg !142, !tbaa !37
  call void @llvm.dbg.value(metadata i32 %8, metadata !125, metadata !DIExpression()), !dbg !139
  %9 = getelementptr inbounds i32, ptr %0, i64 3, !dbg !143
  %10 = load i32, ptr %9, align 4, !dbg !143, !tbaa !37
  call void @llvm.dbg.value(metadata i32 %10, metadata !126, metadata !DIExpression()), !dbg !139
  %11 = getelementptr inbounds i32, ptr %0, i64 4, !dbg !144
  %12 = load i32, ptr %11, align 4, !dbg !144, !tbaa !37
  call void @llvm.dbg.value(metadata i32 %12, metadata !127, metadata !DIExpression()), !dbg !139
  %13 = getelementptr inbounds i32, ptr %0, i64 5, !dbg !145
  %14 = load i32, ptr %13, align 4, !dbg !145, !tbaa !37
  call void @llvm.dbg.value(metadata i32 %14, metadata !128, metadata !DIExpression()), !dbg !139
  %15 = getelementptr inbounds i32, ptr %0, i64 6, !dbg !146
  %16 = load i32, ptr %15, align 4, !dbg !146, !tbaa !37
  call void @llvm.dbg.value(metadata i32 %16, metadata !129, metadata !DIExpression()), !dbg !139
  %17 = getelementptr inbounds i32, ptr %0, i64 7, !dbg !147
  %18 = load i32, ptr %17, align 4, !dbg !147, !tbaa !37
  call void @llvm.dbg.value(metadata i32 %18, metadata !130, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 0, metadata !131, metadata !DIExpression()), !dbg !148
  call void @llvm.dbg.value(metadata i32 %4, metadata !123, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %6, metadata !124, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %8, metadata !125, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %10, metadata !126, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %16, metadata !129, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %14, metadata !128, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %12, metadata !127, metadata !DIExpression()), !dbg !139
  br label %28, !dbg !149

19:                                               ; preds = %28
  %20 = add i32 %66, %4, !dbg !150
  store i32 %20, ptr %0, align 4, !dbg !150, !tbaa !37
  %21 = add i32 %30, %6, !dbg !151
  store i32 %21, ptr %5, align 4, !dbg !151, !tbaa !37
  %22 = add i32 %31, %8, !dbg !152
  store i32 %22, ptr %7, align 4, !dbg !152, !tbaa !37
  %23 = add i32 %32, %10, !dbg !153
  store i32 %23, ptr %9, align 4, !dbg !153, !tbaa !37
  %24 = add i32 %65, %12, !dbg !154
  store i32 %24, ptr %11, align 4, !dbg !154, !tbaa !37
  %25 = add i32 %37, %14, !dbg !155
  store i32 %25, ptr %13, align 4, !dbg !155, !tbaa !37
  %26 = add i32 %36, %16, !dbg !156
  store i32 %26, ptr %15, align 4, !dbg !156, !tbaa !37
  %27 = add i32 %35, %18, !dbg !157
  store i32 %27, ptr %17, align 4, !dbg !157, !tbaa !37
  ret void, !dbg !158

28:                                               ; preds = %3, %28
  %29 = phi i64 [ 0, %3 ], [ %67, %28 ]
  %30 = phi i32 [ %4, %3 ], [ %66, %28 ]
  %31 = phi i32 [ %6, %3 ], [ %30, %28 ]
  %32 = phi i32 [ %8, %3 ], [ %31, %28 ]
  %33 = phi i32 [ %10, %3 ], [ %32, %28 ]
  %34 = phi i32 [ %18, %3 ], [ %35, %28 ]
  %35 = phi i32 [ %16, %3 ], [ %36, %28 ]
  %36 = phi i32 [ %14, %3 ], [ %37, %28 ]
  %37 = phi i32 [ %12, %3 ], [ %65, %28 ]
  call void @llvm.dbg.value(metadata i32 %30, metadata !123, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %31, metadata !124, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %32, metadata !125, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %33, metadata !126, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i64 %29, metadata !131, metadata !DIExpression()), !dbg !148
  call void @llvm.dbg.value(metadata i32 %34, metadata !130, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %35, metadata !129, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %36, metadata !128, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %37, metadata !127, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %37, metadata !79, metadata !DIExpression()), !dbg !159
  call void @llvm.dbg.value(metadata i32 6, metadata !84, metadata !DIExpression()), !dbg !159
  %38 = tail call i32 @llvm.fshl.i32(i32 %37, i32 %37, i32 26), !dbg !161
  call void @llvm.dbg.value(metadata i32 %37, metadata !79, metadata !DIExpression()), !dbg !162
  call void @llvm.dbg.value(metadata i32 11, metadata !84, metadata !DIExpression()), !dbg !162
  %39 = tail call i32 @llvm.fshl.i32(i32 %37, i32 %37, i32 21), !dbg !164
  %40 = xor i32 %38, %39, !dbg !165
  call void @llvm.dbg.value(metadata i32 %37, metadata !79, metadata !DIExpression()), !dbg !166
  call void @llvm.dbg.value(metadata i32 25, metadata !84, metadata !DIExpression()), !dbg !166
  %41 = tail call i32 @llvm.fshl.i32(i32 %37, i32 %37, i32 7), !dbg !168
  %42 = xor i32 %40, %41, !dbg !169
  call void @llvm.dbg.value(metadata i32 %42, metadata !133, metadata !DIExpression()), !dbg !170
  %43 = and i32 %36, %37, !dbg !171
  %44 = xor i32 %37, -1, !dbg !172
  %45 = and i32 %35, %44, !dbg !173
  %46 = getelementptr inbounds i32, ptr %2, i64 %29, !dbg !174
  %47 = load i32, ptr %46, align 4, !dbg !174, !tbaa !37
  %48 = getelementptr inbounds i32, ptr %1, i64 %29, !dbg !175
  %49 = load i32, ptr %48, align 4, !dbg !175, !tbaa !37
  %50 = add i32 %42, %43, !dbg !176
  %51 = add i32 %50, %34, !dbg !177
  %52 = add i32 %51, %45, !dbg !178
  %53 = add i32 %52, %47, !dbg !179
  %54 = add i32 %53, %49, !dbg !180
  call void @llvm.dbg.value(metadata i32 %54, metadata !136, metadata !DIExpression()), !dbg !170
  call void @llvm.dbg.value(metadata i32 %30, metadata !79, metadata !DIExpression()), !dbg !181
  call void @llvm.dbg.value(metadata i32 2, metadata !84, metadata !DIExpression()), !dbg !181
  %55 = tail call i32 @llvm.fshl.i32(i32 %30, i32 %30, i32 30), !dbg !183
  call void @llvm.dbg.value(metadata i32 %30, metadata !79, metadata !DIExpression()), !dbg !184
  call void @llvm.dbg.value(metadata i32 13, metadata !84, metadata !DIExpression()), !dbg !184
  %56 = tail call i32 @llvm.fshl.i32(i32 %30, i32 %30, i32 19), !dbg !186
  %57 = xor i32 %55, %56, !dbg !187
  call void @llvm.dbg.value(metadata i32 %30, metadata !79, metadata !DIExpression()), !dbg !188
  call void @llvm.dbg.value(metadata i32 22, metadata !84, metadata !DIExpression()), !dbg !188
  %58 = tail call i32 @llvm.fshl.i32(i32 %30, i32 %30, i32 10), !dbg !190
  %59 = xor i32 %57, %58, !dbg !191
  call void @llvm.dbg.value(metadata i32 %59, metadata !137, metadata !DIExpression()), !dbg !170
  %60 = xor i32 %31, %32, !dbg !192
  %61 = and i32 %30, %60, !dbg !192
  %62 = and i32 %31, %32, !dbg !193
  %63 = xor i32 %61, %62, !dbg !194
  %64 = add i32 %59, %63, !dbg !195
  call void @llvm.dbg.value(metadata i32 %64, metadata !138, metadata !DIExpression()), !dbg !170
  call void @llvm.dbg.value(metadata i32 %35, metadata !130, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %36, metadata !129, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %37, metadata !128, metadata !DIExpression()), !dbg !139
  %65 = add i32 %54, %33, !dbg !196
  call void @llvm.dbg.value(metadata i32 %65, metadata !127, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %32, metadata !126, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %31, metadata !125, metadata !DIExpression()), !dbg !139
  call void @llvm.dbg.value(metadata i32 %30, metadata !124, metadata !DIExpression()), !dbg !139
  %66 = add i32 %64, %54, !dbg !197
  call void @llvm.dbg.value(metadata i32 %66, metadata !123, metadata !DIExpression()), !dbg !139
  %67 = add nuw nsw i64 %29, 1, !dbg !198
  call void @llvm.dbg.value(metadata i64 %67, metadata !131, metadata !DIExpression()), !dbg !148
  %68 = icmp eq i64 %67, 64, !dbg !199
  br i1 %68, label %19, label %28, !dbg !149, !llvm.loop !200
}

; Function Attrs: nofree nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @mandelbrot(ptr nocapture noundef readonly %0, float noundef %1, ptr nocapture noundef writeonly %2, i32 noundef %3, i32 noundef %4) local_unnamed_addr #2 !dbg !202 {
  call void @llvm.dbg.value(metadata ptr %0, metadata !210, metadata !DIExpression()), !dbg !224
  call void @llvm.dbg.value(metadata float %1, metadata !211, metadata !DIExpression()), !dbg !224
  call void @llvm.dbg.value(metadata ptr %2, metadata !212, metadata !DIExpression()), !dbg !224
  call void @llvm.dbg.value(metadata i32 %3, metadata !213, metadata !DIExpression()), !dbg !224
  call void @llvm.dbg.value(metadata i32 %4, metadata !214, metadata !DIExpression()), !dbg !224
  call void @llvm.dbg.value(metadata i32 0, metadata !215, metadata !DIExpression()), !dbg !225
  %6 = icmp sgt i32 %3, 0, !dbg !226
  br i1 %6, label %7, label %14, !dbg !227

7:                                                ; preds = %5
  %8 = icmp sgt i32 %4, 0
  %9 = zext i32 %3 to i64, !dbg !226
  br label %10, !dbg !227

10:                                               ; preds = %7, %31
  %11 = phi i64 [ 0, %7 ], [ %34, %31 ]
  call void @llvm.dbg.value(metadata i64 %11, metadata !215, metadata !DIExpression()), !dbg !225
  call void @llvm.dbg.value(metadata i32 0, metadata !221, metadata !DIExpression()), !dbg !228
  call void @llvm.dbg.value(metadata float 0.000000e+00, metadata !220, metadata !DIExpression()), !dbg !228
  call void @llvm.dbg.value(metadata float 0.000000e+00, metadata !217, metadata !DIExpression()), !dbg !228
  br i1 %8, label %12, label %31, !dbg !229

12:                                               ; preds = %10
  %13 = getelementptr inbounds float, ptr %0, i64 %11
  br label %15, !dbg !229

14:                                               ; preds = %31, %5
  ret void, !dbg !230

15:                                               ; preds = %12, %22
  %16 = phi i32 [ 0, %12 ], [ %29, %22 ]
  %17 = phi float [ 0.000000e+00, %12 ], [ %28, %22 ]
  %18 = phi float [ 0.000000e+00, %12 ], [ %26, %22 ]
  call void @llvm.dbg.value(metadata i32 %16, metadata !221, metadata !DIExpression()), !dbg !228
  call void @llvm.dbg.value(metadata float %17, metadata !220, metadata !DIExpression()), !dbg !228
  call void @llvm.dbg.value(metadata float %18, metadata !217, metadata !DIExpression()), !dbg !228
  %19 = fmul float %17, %17, !dbg !231
  %20 = tail call float @llvm.fmuladd.f32(float %18, float %18, float %19), !dbg !232
  %21 = fcmp ugt float %20, 4.000000e+00, !dbg !233
  br i1 %21, label %31, label %22, !dbg !234

22:                                               ; preds = %15
  %23 = fneg float %19, !dbg !235
  %24 = tail call float @llvm.fmuladd.f32(float %18, float %18, float %23), !dbg !235
  %25 = load float, ptr %13, align 4, !dbg !236, !tbaa !237
  %26 = fadd float %24, %25, !dbg !239
  call void @llvm.dbg.value(metadata float %26, metadata !222, metadata !DIExpression()), !dbg !240
  %27 = fmul float %18, 2.000000e+00, !dbg !241
  %28 = tail call float @llvm.fmuladd.f32(float %27, float %17, float %1), !dbg !242
  call void @llvm.dbg.value(metadata float %28, metadata !220, metadata !DIExpression()), !dbg !228
  call void @llvm.dbg.value(metadata float %26, metadata !217, metadata !DIExpression()), !dbg !228
  %29 = add nuw nsw i32 %16, 1, !dbg !243
  call void @llvm.dbg.value(metadata i32 %29, metadata !221, metadata !DIExpression()), !dbg !228
  %30 = icmp eq i32 %29, %4, !dbg !244
  br i1 %30, label %31, label %15, !dbg !229, !llvm.loop !245

31:                                               ; preds = %15, %22, %10
  %32 = phi i32 [ 0, %10 ], [ %16, %15 ], [ %4, %22 ], !dbg !228
  %33 = getelementptr inbounds i32, ptr %2, i64 %11, !dbg !247
  store i32 %32, ptr %33, align 4, !dbg !248, !tbaa !37
  %34 = add nuw nsw i64 %11, 1, !dbg !249
  call void @llvm.dbg.value(metadata i64 %34, metadata !215, metadata !DIExpression()), !dbg !225
  %35 = icmp eq i64 %34, %9, !dbg !226
  br i1 %35, label %14, label %10, !dbg !227, !llvm.loop !250
}

; Function Attrs: mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare float @llvm.fmuladd.f32(float, float, float) #3

; Function Attrs: nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare void @llvm.dbg.value(metadata, metadata, metadata) #4

; Function Attrs: nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare i32 @llvm.fshl.i32(i32, i32, i32) #4

attributes #0 = { nofree norecurse nosync nounwind memory(argmem: read) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #1 = { nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #2 = { nofree nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #3 = { mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none) }
attributes #4 = { nocallback nofree nosync nounwind speculatable willreturn memory(none) }

!llvm.dbg.cu = !{!0}
!llvm.module.flags = !{!2, !3, !4, !5, !6, !7}
!llvm.ident = !{!8}

!0 = distinct !DICompileUnit(language: DW_LANG_C11, file: !1, producer: "Debian clang version 16.0.6 (15~deb12u1)", isOptimized: true, runtimeVersion: 0, emissionKind: FullDebug, splitDebugInlining: false, nameTableKind: None)
!1 = !DIFile(filename: "integers.c", directory: ".", checksumkind: CSK_MD5, checksum: "5e88cb3431ce7b65f85b6da9c0fcda40")
!2 = !{i32 7, !"Dwarf Version", i32 5}
!3 = !{i32 2, !"Debug Info Version", i32 3}
!4 = !{i32 1, !"wchar_size", i32 4}
!5 = !{i32 8, !"PIC Level", i32 2}
!6 = !{i32 7, !"PIE Level", i32 2}
!7 = !{i32 7, !"uwtable", i32 2}
!8 = !{!"Debian clang version 16.0.6 (15~deb12u1)"}
!9 = distinct !DISubprogram(name: "crc32", scope: !1, file: !1, line: 11, type: !10, scopeLine: 12, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !20)
!10 = !DISubroutineType(types: !11)
!11 = !{!12, !17, !19}
!12 = !DIDerivedType(tag: DW_TAG_typedef, name: "uint32_t", file: !13, line: 26, baseType: !14)
!13 = !DIFile(filename: "/usr/include/x86_64-linux-gnu/bits/stdint-uintn.h", directory: "", checksumkind: CSK_MD5, checksum: "2bf2ae53c58c01b1a1b9383b5195125c")
!14 = !DIDerivedType(tag: DW_TAG_typedef, name: "__uint32_t", file: !15, line: 42, baseType: !16)
!15 = !DIFile(filename: "/usr/include/x86_64-linux-gnu/bits/types.h", directory: "", checksumkind: CSK_MD5, checksum: "d108b5f93a74c50510d7d9bc0ab36df9")
!16 = !DIBasicType(name: "unsigned int", size: 32, encoding: DW_ATE_unsigned)
!17 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !18, size: 64)
!18 = !DIDerivedType(tag: DW_TAG_const_type, baseType: !12)
!19 = !DIBasicType(name: "int", size: 32, encoding: DW_ATE_signed)
!20 = !{!21, !22, !23, !24, !26}
!21 = !DILocalVariable(name: "words", arg: 1, scope: !9, file: !1, line: 11, type: !17)
!22 = !DILocalVariable(name: "n", arg: 2, scope: !9, file: !1, line: 11, type: !19)
!23 = !DILocalVariable(name: "crc", scope: !9, file: !1, line: 13, type: !12)
!24 = !DILocalVariable(name: "i", scope: !25, file: !1, line: 14, type: !19)
!25 = distinct !DILexicalBlock(scope: !9, file: !1, line: 14, column: 5)
!26 = !DILocalVariable(name: "bit", scope: !27, file: !1, line: 16, type: !19)
!27 = distinct !DILexicalBlock(scope: !28, file: !1, line: 16, column: 9)
!28 = distinct !DILexicalBlock(scope: !29, file: !1, line: 14, column: 33)
!29 = distinct !DILexicalBlock(scope: !25, file: !1, line: 14, column: 5)
!30 = !DILocation(line: 0, scope: !9)
!31 = !DILocation(line: 0, scope: !25)
!32 = !DILocation(line: 14, column: 23, scope: !29)
!33 = !DILocation(line: 14, column: 5, scope: !25)
!34 = !DILocation(line: 19, column: 12, scope: !9)
!35 = !DILocation(line: 19, column: 5, scope: !9)
!36 = !DILocation(line: 15, column: 16, scope: !28)
!37 = !{!38, !38, i64 0}
!38 = !{!"int", !39, i64 0}
!39 = !{!"omnipotent char", !40, i64 0}
!40 = !{!"Simple C/C++ TBAA"}
!41 = !DILocation(line: 15, column: 13, scope: !28)
!42 = !DILocation(line: 0, scope: !27)
!43 = !DILocation(line: 16, column: 9, scope: !27)
!44 = !DILocation(line: 14, column: 29, scope: !29)
!45 = distinct !{!45, !33, !46, !47, !48}
!46 = !DILocation(line: 18, column: 5, scope: !25)
!47 = !{!"llvm.loop.mustprogress"}
!48 = !{!"llvm.loop.unroll.disable"}
!49 = !DILocation(line: 17, column: 23, scope: !50)
!50 = distinct !DILexicalBlock(scope: !27, file: !1, line: 16, column: 9)
!51 = !DILocation(line: 17, column: 19, scope: !50)
!52 = !DILocation(line: 16, column: 40, scope: !50)
!53 = !DILocation(line: 16, column: 31, scope: !50)
!54 = distinct !{!54, !43, !55, !47, !48}
!55 = !DILocation(line: 17, column: 61, scope: !27)
!56 = distinct !DISubprogram(name: "sha256_schedule", scope: !1, file: !1, line: 23, type: !57, scopeLine: 24, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !60)
!57 = !DISubroutineType(types: !58)
!58 = !{null, !59}
!59 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !12, size: 64)
!60 = !{!61, !62, !64, !67, !68, !69}
!61 = !DILocalVariable(name: "w", arg: 1, scope: !56, file: !1, line: 23, type: !59)
!62 = !DILocalVariable(name: "i", scope: !63, file: !1, line: 25, type: !19)
!63 = distinct !DILexicalBlock(scope: !56, file: !1, line: 25, column: 5)
!64 = !DILocalVariable(name: "a", scope: !65, file: !1, line: 26, type: !12)
!65 = distinct !DILexicalBlock(scope: !66, file: !1, line: 25, column: 35)
!66 = distinct !DILexicalBlock(scope: !63, file: !1, line: 25, column: 5)
!67 = !DILocalVariable(name: "b", scope: !65, file: !1, line: 26, type: !12)
!68 = !DILocalVariable(name: "s0", scope: !65, file: !1, line: 27, type: !12)
!69 = !DILocalVariable(name: "s1", scope: !65, file: !1, line: 28, type: !12)
!70 = !DILocation(line: 0, scope: !56)
!71 = !DILocation(line: 0, scope: !63)
!72 = !DILocation(line: 25, column: 5, scope: !63)
!73 = !DILocation(line: 31, column: 1, scope: !56)
!74 = !DILocation(line: 26, column: 26, scope: !65)
!75 = !DILocation(line: 26, column: 22, scope: !65)
!76 = !DILocation(line: 0, scope: !65)
!77 = !DILocation(line: 26, column: 41, scope: !65)
!78 = !DILocation(line: 26, column: 37, scope: !65)
!79 = !DILocalVariable(name: "x", arg: 1, scope: !80, file: !1, line: 5, type: !12)
!80 = distinct !DISubprogram(name: "rotr", scope: !1, file: !1, line: 5, type: !81, scopeLine: 6, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagLocalToUnit | DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !83)
!81 = !DISubroutineType(types: !82)
!82 = !{!12, !12, !19}
!83 = !{!79, !84}
!84 = !DILocalVariable(name: "by", arg: 2, scope: !80, file: !1, line: 5, type: !19)
!85 = !DILocation(line: 0, scope: !80, inlinedAt: !86)
!86 = distinct !DILocation(line: 27, column: 23, scope: !65)
!87 = !DILocation(line: 7, column: 20, scope: !80, inlinedAt: !86)
!88 = !DILocation(line: 0, scope: !80, inlinedAt: !89)
!89 = distinct !DILocation(line: 27, column: 36, scope: !65)
!90 = !DILocation(line: 7, column: 20, scope: !80, inlinedAt: !89)
!91 = !DILocation(line: 27, column: 34, scope: !65)
!92 = !DILocation(line: 27, column: 52, scope: !65)
!93 = !DILocation(line: 27, column: 48, scope: !65)
!94 = !DILocation(line: 0, scope: !80, inlinedAt: !95)
!95 = distinct !DILocation(line: 28, column: 23, scope: !65)
!96 = !DILocation(line: 7, column: 20, scope: !80, inlinedAt: !95)
!97 = !DILocation(line: 0, scope: !80, inlinedAt: !98)
!98 = distinct !DILocation(line: 28, column: 37, scope: !65)
!99 = !DILocation(line: 7, column: 20, scope: !80, inlinedAt: !98)
!100 = !DILocation(line: 28, column: 35, scope: !65)
!101 = !DILocation(line: 28, column: 53, scope: !65)
!102 = !DILocation(line: 28, column: 49, scope: !65)
!103 = !DILocation(line: 29, column: 20, scope: !65)
!104 = !DILocation(line: 29, column: 16, scope: !65)
!105 = !DILocation(line: 29, column: 26, scope: !65)
!106 = !DILocation(line: 29, column: 37, scope: !65)
!107 = !DILocation(line: 29, column: 33, scope: !65)
!108 = !DILocation(line: 29, column: 31, scope: !65)
!109 = !DILocation(line: 29, column: 42, scope: !65)
!110 = !DILocation(line: 29, column: 9, scope: !65)
!111 = !DILocation(line: 29, column: 14, scope: !65)
!112 = !DILocation(line: 25, column: 31, scope: !66)
!113 = !DILocation(line: 25, column: 24, scope: !66)
!114 = distinct !{!114, !72, !115, !47, !48}
!115 = !DILocation(line: 30, column: 5, scope: !63)
!116 = distinct !DISubprogram(name: "sha256_rounds", scope: !1, file: !1, line: 34, type: !117, scopeLine: 35, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !119)
!117 = !DISubroutineType(types: !118)
!118 = !{null, !59, !17, !17}
!119 = !{!120, !121, !122, !123, !124, !125, !126, !127, !128, !129, !130, !131, !133, !136, !137, !138}
!120 = !DILocalVariable(name: "state", arg: 1, scope: !116, file: !1, line: 34, type: !59)
!121 = !DILocalVariable(name: "w", arg: 2, scope: !116, file: !1, line: 34, type: !17)
!122 = !DILocalVariable(name: "constants", arg: 3, scope: !116, file: !1, line: 34, type: !17)
!123 = !DILocalVariable(name: "a", scope: !116, file: !1, line: 36, type: !12)
!124 = !DILocalVariable(name: "b", scope: !116, file: !1, line: 36, type: !12)
!125 = !DILocalVariable(name: "c", scope: !116, file: !1, line: 36, type: !12)
!126 = !DILocalVariable(name: "d", scope: !116, file: !1, line: 36, type: !12)
!127 = !DILocalVariable(name: "e", scope: !116, file: !1, line: 37, type: !12)
!128 = !DILocalVariable(name: "f", scope: !116, file: !1, line: 37, type: !12)
!129 = !DILocalVariable(name: "g", scope: !116, file: !1, line: 37, type: !12)
!130 = !DILocalVariable(name: "h", scope: !116, file: !1, line: 37, type: !12)
!131 = !DILocalVariable(name: "i", scope: !132, file: !1, line: 38, type: !19)
!132 = distinct !DILexicalBlock(scope: !116, file: !1, line: 38, column: 5)
!133 = !DILocalVariable(name: "s1", scope: !134, file: !1, line: 39, type: !12)
!134 = distinct !DILexicalBlock(scope: !135, file: !1, line: 38, column: 34)
!135 = distinct !DILexicalBlock(scope: !132, file: !1, line: 38, column: 5)
!136 = !DILocalVariable(name: "t1", scope: !134, file: !1, line: 40, type: !12)
!137 = !DILocalVariable(name: "s0", scope: !134, file: !1, line: 41, type: !12)
!138 = !DILocalVariable(name: "t2", scope: !134, file: !1, line: 42, type: !12)
!139 = !DILocation(line: 0, scope: !116)
!140 = !DILocation(line: 36, column: 18, scope: !116)
!141 = !DILocation(line: 36, column: 32, scope: !116)
!142 = !DILocation(line: 36, column: 46, scope: !116)
!143 = !DILocation(line: 36, column: 60, scope: !116)
!144 = !DILocation(line: 37, column: 18, scope: !116)
!145 = !DILocation(line: 37, column: 32, scope: !116)
!146 = !DILocation(line: 37, column: 46, scope: !116)
!147 = !DILocation(line: 37, column: 60, scope: !116)
!148 = !DILocation(line: 0, scope: !132)
!149 = !DILocation(line: 38, column: 5, scope: !132)
!150 = !DILocation(line: 46, column: 14, scope: !116)
!151 = !DILocation(line: 46, column: 29, scope: !116)
!152 = !DILocation(line: 46, column: 44, scope: !116)
!153 = !DILocation(line: 46, column: 59, scope: !116)
!154 = !DILocation(line: 47, column: 14, scope: !116)
!155 = !DILocation(line: 47, column: 29, scope: !116)
!156 = !DILocation(line: 47, column: 44, scope: !116)
!157 = !DILocation(line: 47, column: 59, scope: !116)
!158 = !DILocation(line: 48, column: 1, scope: !116)
!159 = !DILocation(line: 0, scope: !80, inlinedAt: !160)
!160 = distinct !DILocation(line: 39, column: 23, scope: !134)
!161 = !DILocation(line: 7, column: 20, scope: !80, inlinedAt: !160)
!162 = !DILocation(line: 0, scope: !80, inlinedAt: !163)
!163 = distinct !DILocation(line: 39, column: 36, scope: !134)
!164 = !DILocation(line: 7, column: 20, scope: !80, inlinedAt: !163)
!165 = !DILocation(line: 39, column: 34, scope: !134)
!166 = !DILocation(line: 0, scope: !80, inlinedAt: !167)
!167 = distinct !DILocation(line: 39, column: 50, scope: !134)
!168 = !DILocation(line: 7, column: 20, scope: !80, inlinedAt: !167)
!169 = !DILocation(line: 39, column: 48, scope: !134)
!170 = !DILocation(line: 0, scope: !134)
!171 = !DILocation(line: 40, column: 36, scope: !134)
!172 = !DILocation(line: 40, column: 44, scope: !134)
!173 = !DILocation(line: 40, column: 47, scope: !134)
!174 = !DILocation(line: 40, column: 55, scope: !134)
!175 = !DILocation(line: 40, column: 70, scope: !134)
!176 = !DILocation(line: 40, column: 41, scope: !134)
!177 = !DILocation(line: 40, column: 25, scope: !134)
!178 = !DILocation(line: 40, column: 30, scope: !134)
!179 = !DILocation(line: 40, column: 53, scope: !134)
!180 = !DILocation(line: 40, column: 68, scope: !134)
!181 = !DILocation(line: 0, scope: !80, inlinedAt: !182)
!182 = distinct !DILocation(line: 41, column: 23, scope: !134)
!183 = !DILocation(line: 7, column: 20, scope: !80, inlinedAt: !182)
!184 = !DILocation(line: 0, scope: !80, inlinedAt: !185)
!185 = distinct !DILocation(line: 41, column: 36, scope: !134)
!186 = !DILocation(line: 7, column: 20, scope: !80, inlinedAt: !185)
!187 = !DILocation(line: 41, column: 34, scope: !134)
!188 = !DILocation(line: 0, scope: !80, inlinedAt: !189)
!189 = distinct !DILocation(line: 41, column: 50, scope: !134)
!190 = !DILocation(line: 7, column: 20, scope: !80, inlinedAt: !189)
!191 = !DILocation(line: 41, column: 48, scope: !134)
!192 = !DILocation(line: 42, column: 37, scope: !134)
!193 = !DILocation(line: 42, column: 52, scope: !134)
!194 = !DILocation(line: 42, column: 47, scope: !134)
!195 = !DILocation(line: 42, column: 26, scope: !134)
!196 = !DILocation(line: 43, column: 36, scope: !134)
!197 = !DILocation(line: 44, column: 37, scope: !134)
!198 = !DILocation(line: 38, column: 30, scope: !135)
!199 = !DILocation(line: 38, column: 23, scope: !135)
!200 = distinct !{!200, !149, !201, !47, !48}
!201 = !DILocation(line: 45, column: 5, scope: !132)
!202 = distinct !DISubprogram(name: "mandelbrot", scope: !1, file: !1, line: 51, type: !203, scopeLine: 52, flags: DIFlagPrototyped | DIFlagAllCallsDescribed, spFlags: DISPFlagDefinition | DISPFlagOptimized, unit: !0, retainedNodes: !209)
!203 = !DISubroutineType(types: !204)
!204 = !{null, !205, !207, !208, !19, !19}
!205 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !206, size: 64)
!206 = !DIDerivedType(tag: DW_TAG_const_type, baseType: !207)
!207 = !DIBasicType(name: "float", size: 32, encoding: DW_ATE_float)
!208 = !DIDerivedType(tag: DW_TAG_pointer_type, baseType: !19, size: 64)
!209 = !{!210, !211, !212, !213, !214, !215, !217, !220, !221, !222}
!210 = !DILocalVariable(name: "re", arg: 1, scope: !202, file: !1, line: 51, type: !205)
!211 = !DILocalVariable(name: "im", arg: 2, scope: !202, file: !1, line: 51, type: !207)
!212 = !DILocalVariable(name: "count", arg: 3, scope: !202, file: !1, line: 51, type: !208)
!213 = !DILocalVariable(name: "n", arg: 4, scope: !202, file: !1, line: 51, type: !19)
!214 = !DILocalVariable(name: "limit", arg: 5, scope: !202, file: !1, line: 51, type: !19)
!215 = !DILocalVariable(name: "i", scope: !216, file: !1, line: 53, type: !19)
!216 = distinct !DILexicalBlock(scope: !202, file: !1, line: 53, column: 5)
!217 = !DILocalVariable(name: "x", scope: !218, file: !1, line: 54, type: !207)
!218 = distinct !DILexicalBlock(scope: !219, file: !1, line: 53, column: 33)
!219 = distinct !DILexicalBlock(scope: !216, file: !1, line: 53, column: 5)
!220 = !DILocalVariable(name: "y", scope: !218, file: !1, line: 54, type: !207)
!221 = !DILocalVariable(name: "k", scope: !218, file: !1, line: 55, type: !19)
!222 = !DILocalVariable(name: "t", scope: !223, file: !1, line: 57, type: !207)
!223 = distinct !DILexicalBlock(scope: !218, file: !1, line: 56, column: 52)
!224 = !DILocation(line: 0, scope: !202)
!225 = !DILocation(line: 0, scope: !216)
!226 = !DILocation(line: 53, column: 23, scope: !219)
!227 = !DILocation(line: 53, column: 5, scope: !216)
!228 = !DILocation(line: 0, scope: !218)
!229 = !DILocation(line: 56, column: 26, scope: !218)
!230 = !DILocation(line: 64, column: 1, scope: !202)
!231 = !DILocation(line: 56, column: 39, scope: !218)
!232 = !DILocation(line: 56, column: 35, scope: !218)
!233 = !DILocation(line: 56, column: 43, scope: !218)
!234 = !DILocation(line: 56, column: 9, scope: !218)
!235 = !DILocation(line: 57, column: 29, scope: !223)
!236 = !DILocation(line: 57, column: 39, scope: !223)
!237 = !{!238, !238, i64 0}
!238 = !{!"float", !39, i64 0}
!239 = !DILocation(line: 57, column: 37, scope: !223)
!240 = !DILocation(line: 0, scope: !223)
!241 = !DILocation(line: 58, column: 22, scope: !223)
!242 = !DILocation(line: 58, column: 30, scope: !223)
!243 = !DILocation(line: 60, column: 14, scope: !223)
!244 = !DILocation(line: 56, column: 18, scope: !218)
!245 = distinct !{!245, !234, !246, !47, !48}
!246 = !DILocation(line: 61, column: 9, scope: !218)
!247 = !DILocation(line: 62, column: 9, scope: !218)
!248 = !DILocation(line: 62, column: 18, scope: !218)
!249 = !DILocation(line: 53, column: 29, scope: !219)
!250 = distinct !{!250, !227, !251, !47, !48}
!251 = !DILocation(line: 63, column: 5, scope: !216)
