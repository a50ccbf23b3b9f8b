; ModuleID = 'memory.c'
source_filename = "memory.c"
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"
target triple = "x86_64-pc-linux-gnu"

%struct.P = type { i8, i16, i32 }
%union.anon = type { float }

@tab2.t = internal unnamed_addr constant [4 x [4 x i8]] [[4 x i8] c"\FF\02\FD\04", [4 x i8] c"\05\06\F9\08", [4 x i8] c"\00\00\01\00", [4 x i8] c"\09\F7\7F\80"], align 16
@tab16.t = internal unnamed_addr constant [5 x i16] [i16 -32768, i16 2, i16 -3, i16 32767, i16 7], align 2
@tab64.t = internal unnamed_addr constant [4 x i64] [i64 -5, i64 6, i64 7, i64 -2147483648], align 16
@tabf.t = internal unnamed_addr constant [4 x float] [float 1.500000e+00, float -2.000000e+00, float 0.000000e+00, float 3.250000e+00], align 16
@__const.init8.t = private unnamed_addr constant [16 x i8] c"\01\02\03\04\05\06\07\08\09\0A\0B\0C\0D\0E\0F\10", align 16
@base64.t = internal unnamed_addr constant [65 x i8] c"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/\00", align 16
@count = internal unnamed_addr global i32 0, align 4

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: read) uwtable
define dso_local i64 @sum64(ptr nocapture noundef readonly %0, i64 noundef %1, i64 noundef %2) local_unnamed_addr #0 {
  %4 = icmp sgt i64 %1, 0
  br i1 %4, label %7, label %5

5:                                                ; preds = %7, %3
  %6 = phi i64 [ %2, %3 ], [ %13, %7 ]
  ret i64 %6

7:                                                ; preds = %3, %7
  %8 = phi i64 [ %14, %7 ], [ 0, %3 ]
  %9 = phi i64 [ %13, %7 ], [ %2, %3 ]
  %10 = getelementptr inbounds i32, ptr %0, i64 %8
  %11 = load i32, ptr %10, align 4, !tbaa !5
  %12 = sext i32 %11 to i64
  %13 = add nsw i64 %9, %12
  %14 = add nuw nsw i64 %8, 1
  %15 = icmp eq i64 %14, %1
  br i1 %15, label %5, label %7, !llvm.loop !9
}

; Function Attrs: mustprogress nocallback nofree nosync nounwind willreturn memory(argmem: readwrite)
declare void @llvm.lifetime.start.p0(i64 immarg, ptr nocapture) #1

; Function Attrs: mustprogress nocallback nofree nosync nounwind willreturn memory(argmem: readwrite)
declare void @llvm.lifetime.end.p0(i64 immarg, ptr nocapture) #1

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable
define dso_local i64 @div64(i64 noundef %0, i64 noundef %1) local_unnamed_addr #2 {
  %3 = icmp eq i64 %1, 0
  br i1 %3, label %6, label %4

4:                                                ; preds = %2
  %5 = sdiv i64 %0, %1
  br label %6

6:                                                ; preds = %2, %4
  %7 = phi i64 [ %5, %4 ], [ 0, %2 ]
  ret i64 %7
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable
define dso_local i64 @udiv64(i64 noundef %0, i64 noundef %1) local_unnamed_addr #2 {
  %3 = icmp eq i64 %1, 0
  br i1 %3, label %6, label %4

4:                                                ; preds = %2
  %5 = urem i64 %0, %1
  br label %6

6:                                                ; preds = %2, %4
  %7 = phi i64 [ %5, %4 ], [ %0, %2 ]
  ret i64 %7
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable
define dso_local i64 @muladd(i64 noundef %0, i32 noundef %1) local_unnamed_addr #2 {
  %3 = sext i32 %1 to i64
  %4 = mul nsw i64 %3, %0
  %5 = ashr i64 %0, 3
  %6 = add nsw i64 %4, %5
  ret i64 %6
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable
define dso_local i32 @tab2(i32 noundef %0, i32 noundef %1) local_unnamed_addr #2 {
  %3 = and i32 %0, 3
  %4 = zext i32 %3 to i64
  %5 = and i32 %1, 3
  %6 = zext i32 %5 to i64
  %7 = getelementptr inbounds [4 x [4 x i8]], ptr @tab2.t, i64 0, i64 %4, i64 %6
  %8 = load i8, ptr %7, align 1, !tbaa !12
  %9 = sext i8 %8 to i32
  ret i32 %9
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable
define dso_local i32 @tab16(i32 noundef %0) local_unnamed_addr #2 {
  %2 = urem i32 %0, 5
  %3 = zext i32 %2 to i64
  %4 = getelementptr inbounds [5 x i16], ptr @tab16.t, i64 0, i64 %3
  %5 = load i16, ptr %4, align 2, !tbaa !13
  %6 = sext i16 %5 to i32
  ret i32 %6
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable
define dso_local i64 @tab64(i32 noundef %0) local_unnamed_addr #2 {
  %2 = and i32 %0, 3
  %3 = zext i32 %2 to i64
  %4 = getelementptr inbounds [4 x i64], ptr @tab64.t, i64 0, i64 %3
  %5 = load i64, ptr %4, align 8, !tbaa !15
  ret i64 %5
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable
define dso_local float @tabf(i32 noundef %0) local_unnamed_addr #2 {
  %2 = and i32 %0, 3
  %3 = zext i32 %2 to i64
  %4 = getelementptr inbounds [4 x float], ptr @tabf.t, i64 0, i64 %3
  %5 = load float, ptr %4, align 4, !tbaa !17
  ret float %5
}

; Function Attrs: nofree nosync nounwind memory(none) uwtable
define dso_local i32 @init8(i32 noundef %0) local_unnamed_addr #3 {
  %2 = alloca [16 x i8], align 16
  call void @llvm.lifetime.start.p0(i64 16, ptr nonnull %2) #18
  call void @llvm.memcpy.p0.p0.i64(ptr noundef nonnull align 16 dereferenceable(16) %2, ptr noundef nonnull align 16 dereferenceable(16) @__const.init8.t, i64 16, i1 false)
  %3 = and i32 %0, 15
  %4 = zext i32 %3 to i64
  %5 = getelementptr inbounds [16 x i8], ptr %2, i64 0, i64 %4
  store i8 77, ptr %5, align 1, !tbaa !12
  br label %7

6:                                                ; preds = %7
  call void @llvm.lifetime.end.p0(i64 16, ptr nonnull %2) #18
  ret i32 %14

7:                                                ; preds = %1, %7
  %8 = phi i64 [ 0, %1 ], [ %15, %7 ]
  %9 = phi i32 [ 0, %1 ], [ %14, %7 ]
  %10 = mul nsw i32 %9, 3
  %11 = getelementptr inbounds [16 x i8], ptr %2, i64 0, i64 %8
  %12 = load i8, ptr %11, align 1, !tbaa !12
  %13 = zext i8 %12 to i32
  %14 = add nsw i32 %10, %13
  %15 = add nuw nsw i64 %8, 1
  %16 = icmp eq i64 %15, 16
  br i1 %16, label %6, label %7, !llvm.loop !19
}

; Function Attrs: mustprogress nocallback nofree nounwind willreturn memory(argmem: readwrite)
declare void @llvm.memcpy.p0.p0.i64(ptr noalias nocapture writeonly, ptr noalias nocapture readonly, i64, i1 immarg) #4

; Function Attrs: nofree nosync nounwind memory(none) uwtable
define dso_local i32 @loc2(i32 noundef %0) local_unnamed_addr #3 {
  %2 = alloca [8 x [8 x i32]], align 16
  call void @llvm.lifetime.start.p0(i64 256, ptr nonnull %2) #18
  br label %3

3:                                                ; preds = %1, %5
  %4 = phi i64 [ 0, %1 ], [ %6, %5 ]
  br label %8

5:                                                ; preds = %8
  %6 = add nuw nsw i64 %4, 1
  %7 = icmp eq i64 %6, 8
  br i1 %7, label %17, label %3, !llvm.loop !20

8:                                                ; preds = %3, %8
  %9 = phi i64 [ 0, %3 ], [ %14, %8 ]
  %10 = mul nuw nsw i64 %9, %4
  %11 = trunc i64 %10 to i32
  %12 = add nsw i32 %11, %0
  %13 = getelementptr inbounds [8 x [8 x i32]], ptr %2, i64 0, i64 %4, i64 %9
  store i32 %12, ptr %13, align 4, !tbaa !5
  %14 = add nuw nsw i64 %9, 1
  %15 = icmp eq i64 %14, 8
  br i1 %15, label %5, label %8, !llvm.loop !21

16:                                               ; preds = %17
  call void @llvm.lifetime.end.p0(i64 256, ptr nonnull %2) #18
  ret i32 %26

17:                                               ; preds = %5, %17
  %18 = phi i64 [ %27, %17 ], [ 0, %5 ]
  %19 = phi i32 [ %26, %17 ], [ 0, %5 ]
  %20 = trunc i64 %18 to i32
  %21 = mul i32 %20, %0
  %22 = and i32 %21, 7
  %23 = zext i32 %22 to i64
  %24 = getelementptr inbounds [8 x [8 x i32]], ptr %2, i64 0, i64 %18, i64 %23
  %25 = load i32, ptr %24, align 4, !tbaa !5
  %26 = xor i32 %25, %19
  %27 = add nuw nsw i64 %18, 1
  %28 = icmp eq i64 %27, 8
  br i1 %28, label %16, label %17, !llvm.loop !22
}

; Function Attrs: nofree nosync nounwind memory(none) uwtable
define dso_local i32 @locs(i32 noundef %0) local_unnamed_addr #3 {
  %2 = alloca [10 x %struct.P], align 16
  call void @llvm.lifetime.start.p0(i64 80, ptr nonnull %2) #18
  br label %3

3:                                                ; preds = %1, %3
  %4 = phi i64 [ 0, %1 ], [ %15, %3 ]
  %5 = trunc i64 %4 to i32
  %6 = mul i32 %5, %0
  %7 = trunc i32 %6 to i8
  %8 = getelementptr inbounds [10 x %struct.P], ptr %2, i64 0, i64 %4
  store i8 %7, ptr %8, align 8, !tbaa !23
  %9 = trunc i32 %6 to i16
  %10 = sub i16 0, %9
  %11 = getelementptr inbounds [10 x %struct.P], ptr %2, i64 0, i64 %4, i32 1
  store i16 %10, ptr %11, align 2, !tbaa !25
  %12 = trunc i64 %4 to i32
  %13 = xor i32 %12, %0
  %14 = getelementptr inbounds [10 x %struct.P], ptr %2, i64 0, i64 %4, i32 2
  store i32 %13, ptr %14, align 4, !tbaa !26
  %15 = add nuw nsw i64 %4, 1
  %16 = icmp eq i64 %15, 10
  br i1 %16, label %18, label %3, !llvm.loop !27

17:                                               ; preds = %18
  call void @llvm.lifetime.end.p0(i64 80, ptr nonnull %2) #18
  ret i32 %34

18:                                               ; preds = %3, %18
  %19 = phi i32 [ %34, %18 ], [ 0, %3 ]
  %20 = phi i32 [ %35, %18 ], [ 0, %3 ]
  %21 = mul nsw i32 %20, %0
  %22 = and i32 %21, 7
  %23 = zext i32 %22 to i64
  %24 = getelementptr inbounds [10 x %struct.P], ptr %2, i64 0, i64 %23
  %25 = load i8, ptr %24, align 8, !tbaa.struct !28
  %26 = getelementptr inbounds i8, ptr %24, i64 2
  %27 = load i16, ptr %26, align 2, !tbaa.struct !29
  %28 = getelementptr inbounds i8, ptr %24, i64 4
  %29 = load i32, ptr %28, align 4, !tbaa.struct !30
  %30 = zext i8 %25 to i32
  %31 = sext i16 %27 to i32
  %32 = mul nsw i32 %31, %30
  %33 = add i32 %29, %19
  %34 = add i32 %33, %32
  %35 = add nuw nsw i32 %20, 1
  %36 = icmp eq i32 %35, 10
  br i1 %36, label %17, label %18, !llvm.loop !31
}

; Function Attrs: nounwind uwtable
define dso_local float @maths(float noundef %0, float noundef %1) local_unnamed_addr #5 {
  %3 = tail call float @tanf(float noundef %0) #18
  %4 = tail call float @hypotf(float noundef %0, float noundef %1) #18
  %5 = fadd float %3, %4
  %6 = fmul float %0, %0
  %7 = tail call float @log1pf(float noundef %6) #18
  %8 = fadd float %5, %7
  %9 = tail call float @expm1f(float noundef %0) #18
  %10 = fadd float %8, %9
  %11 = tail call float @fmodf(float noundef %0, float noundef %1) #18
  %12 = fadd float %10, %11
  %13 = fadd float %6, 1.000000e+00
  %14 = fdiv float %0, %13
  %15 = tail call float @asinf(float noundef %14) #18
  %16 = fadd float %12, %15
  %17 = tail call float @llvm.round.f32(float %0)
  %18 = fadd float %17, %16
  %19 = tail call float @atan2f(float noundef %0, float noundef %1) #18
  %20 = fadd float %19, %18
  ret float %20
}

; Function Attrs: mustprogress nofree nounwind willreturn memory(write)
declare float @tanf(float noundef) local_unnamed_addr #6

; Function Attrs: nounwind
declare float @hypotf(float noundef, float noundef) local_unnamed_addr #7

; Function Attrs: mustprogress nofree nounwind willreturn memory(write)
declare float @log1pf(float noundef) local_unnamed_addr #6

; Function Attrs: mustprogress nofree nounwind willreturn memory(write)
declare float @expm1f(float noundef) local_unnamed_addr #6

; Function Attrs: mustprogress nofree nounwind willreturn memory(write)
declare float @fmodf(float noundef, float noundef) local_unnamed_addr #6

; Function Attrs: mustprogress nofree nounwind willreturn memory(write)
declare float @asinf(float noundef) local_unnamed_addr #6

; Function Attrs: mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare float @llvm.round.f32(float) #8

; Function Attrs: mustprogress nofree nounwind willreturn memory(write)
declare float @atan2f(float noundef, float noundef) local_unnamed_addr #6

; Function Attrs: mustprogress nofree nosync nounwind willreturn memory(none) uwtable
define dso_local float @rnd(float noundef %0) local_unnamed_addr #9 {
  %2 = tail call float @llvm.round.f32(float %0)
  ret float %2
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable
define dso_local signext i8 @ret8(i32 noundef %0) local_unnamed_addr #2 {
  %2 = trunc i32 %0 to i8
  ret i8 %2
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable
define dso_local zeroext i16 @ret16(i8 noundef signext %0, i16 noundef zeroext %1) local_unnamed_addr #2 {
  %3 = sext i8 %0 to i16
  %4 = mul i16 %3, %1
  ret i16 %4
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable
define dso_local zeroext i1 @odd(i8 noundef zeroext %0) local_unnamed_addr #2 {
  %2 = and i8 %0, 1
  %3 = icmp ne i8 %2, 0
  ret i1 %3
}

; Function Attrs: mustprogress nofree nosync nounwind willreturn memory(argmem: readwrite) uwtable
define dso_local void @cp(ptr noalias nocapture noundef writeonly %0, ptr noalias nocapture noundef readonly %1, i32 noundef %2) local_unnamed_addr #10 {
  %4 = sext i32 %2 to i64
  tail call void @llvm.memcpy.p0.p0.i64(ptr align 1 %0, ptr align 1 %1, i64 %4, i1 false)
  ret void
}

; Function Attrs: mustprogress nofree nosync nounwind willreturn memory(argmem: readwrite) uwtable
define dso_local void @mv(ptr nocapture noundef %0, i32 noundef %1) local_unnamed_addr #10 {
  %3 = getelementptr inbounds i8, ptr %0, i64 1
  %4 = sext i32 %1 to i64
  tail call void @llvm.memmove.p0.p0.i64(ptr nonnull align 1 %3, ptr align 1 %0, i64 %4, i1 false)
  ret void
}

; Function Attrs: mustprogress nocallback nofree nounwind willreturn memory(argmem: readwrite)
declare void @llvm.memmove.p0.p0.i64(ptr nocapture writeonly, ptr nocapture readonly, i64, i1 immarg) #4

; Function Attrs: mustprogress nofree nosync nounwind willreturn memory(none) uwtable
define dso_local i32 @popc(i64 noundef %0) local_unnamed_addr #9 {
  %2 = tail call i64 @llvm.ctpop.i64(i64 %0), !range !32
  %3 = trunc i64 %2 to i32
  %4 = trunc i64 %0 to i32
  %5 = or i32 %4, 1
  %6 = tail call i32 @llvm.ctlz.i32(i32 %5, i1 true), !range !33
  %7 = add nuw nsw i32 %6, %3
  ret i32 %7
}

; Function Attrs: mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare i64 @llvm.ctpop.i64(i64) #8

; Function Attrs: mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare i32 @llvm.ctlz.i32(i32, i1 immarg) #8

; Function Attrs: nofree norecurse nosync nounwind memory(read, inaccessiblemem: none) uwtable
define dso_local i32 @cmps(ptr nocapture noundef readonly %0, ptr nocapture noundef readonly %1) local_unnamed_addr #11 {
  %3 = load i8, ptr %0, align 1, !tbaa !12
  %4 = icmp eq i8 %3, 0
  br i1 %4, label %16, label %5

5:                                                ; preds = %2, %11
  %6 = phi i8 [ %14, %11 ], [ %3, %2 ]
  %7 = phi ptr [ %13, %11 ], [ %1, %2 ]
  %8 = phi ptr [ %12, %11 ], [ %0, %2 ]
  %9 = load i8, ptr %7, align 1, !tbaa !12
  %10 = icmp eq i8 %6, %9
  br i1 %10, label %11, label %16

11:                                               ; preds = %5
  %12 = getelementptr inbounds i8, ptr %8, i64 1
  %13 = getelementptr inbounds i8, ptr %7, i64 1
  %14 = load i8, ptr %12, align 1, !tbaa !12
  %15 = icmp eq i8 %14, 0
  br i1 %15, label %16, label %5, !llvm.loop !34

16:                                               ; preds = %5, %11, %2
  %17 = phi ptr [ %1, %2 ], [ %7, %5 ], [ %13, %11 ]
  %18 = phi i8 [ %3, %2 ], [ %6, %5 ], [ %14, %11 ]
  %19 = zext i8 %18 to i32
  %20 = load i8, ptr %17, align 1, !tbaa !12
  %21 = zext i8 %20 to i32
  %22 = sub nsw i32 %19, %21
  ret i32 %22
}

; Function Attrs: nofree norecurse nosync nounwind memory(write, argmem: readwrite, inaccessiblemem: none) uwtable
define dso_local void @base64(ptr nocapture noundef readonly %0, ptr nocapture noundef writeonly %1, i32 noundef %2) local_unnamed_addr #12 {
  %4 = icmp sgt i32 %2, 2
  br i1 %4, label %6, label %5

5:                                                ; preds = %24, %3
  ret void

6:                                                ; preds = %3, %24
  %7 = phi i64 [ %25, %24 ], [ 0, %3 ]
  %8 = phi i64 [ %26, %24 ], [ 2, %3 ]
  %9 = phi ptr [ %40, %24 ], [ %1, %3 ]
  %10 = getelementptr inbounds i8, ptr %0, i64 %7
  %11 = load i8, ptr %10, align 1, !tbaa !12
  %12 = zext i8 %11 to i32
  %13 = shl nuw nsw i32 %12, 16
  %14 = add nuw nsw i64 %7, 1
  %15 = getelementptr inbounds i8, ptr %0, i64 %14
  %16 = load i8, ptr %15, align 1, !tbaa !12
  %17 = zext i8 %16 to i32
  %18 = shl nuw nsw i32 %17, 8
  %19 = or i32 %18, %13
  %20 = getelementptr inbounds i8, ptr %0, i64 %8
  %21 = load i8, ptr %20, align 1, !tbaa !12
  %22 = zext i8 %21 to i32
  %23 = or i32 %19, %22
  br label %30

24:                                               ; preds = %30
  %25 = add nuw i64 %7, 3
  %26 = add i64 %8, 3
  %27 = trunc i64 %7 to i32
  %28 = add i32 %27, 5
  %29 = icmp slt i32 %28, %2
  br i1 %29, label %6, label %5, !llvm.loop !35

30:                                               ; preds = %6, %30
  %31 = phi i32 [ 0, %6 ], [ %41, %30 ]
  %32 = phi ptr [ %9, %6 ], [ %40, %30 ]
  %33 = mul nsw i32 %31, -6
  %34 = add nsw i32 %33, 18
  %35 = lshr i32 %23, %34
  %36 = and i32 %35, 63
  %37 = zext i32 %36 to i64
  %38 = getelementptr inbounds [65 x i8], ptr @base64.t, i64 0, i64 %37
  %39 = load i8, ptr %38, align 1, !tbaa !12
  %40 = getelementptr inbounds i8, ptr %32, i64 1
  store i8 %39, ptr %32, align 1, !tbaa !12
  %41 = add nuw nsw i32 %31, 1
  %42 = icmp eq i32 %41, 4
  br i1 %42, label %24, label %30, !llvm.loop !36
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable
define dso_local i64 @mum(i32 noundef %0, i32 noundef %1) local_unnamed_addr #2 {
  %3 = zext i32 %0 to i64
  %4 = zext i32 %1 to i64
  %5 = mul nuw i64 %4, %3
  ret i64 %5
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(argmem: read) uwtable
define dso_local i32 @load4(ptr nocapture noundef readonly %0, i32 noundef %1) local_unnamed_addr #13 {
  %3 = shl nsw i32 %1, 2
  %4 = sext i32 %3 to i64
  %5 = getelementptr inbounds i8, ptr %0, i64 %4
  %6 = load i32, ptr %5, align 1
  ret i32 %6
}

; Function Attrs: nofree nosync nounwind memory(argmem: read) uwtable
define dso_local i32 @rd(ptr nocapture noundef readonly %0, i32 noundef %1) local_unnamed_addr #14 {
  %3 = alloca [4 x i8], align 1
  call void @llvm.lifetime.start.p0(i64 4, ptr nonnull %3) #18
  %4 = icmp sgt i32 %1, 0
  br i1 %4, label %5, label %7

5:                                                ; preds = %2
  %6 = zext i32 %1 to i64
  br label %9

7:                                                ; preds = %9, %2
  %8 = phi i32 [ 0, %2 ], [ %23, %9 ]
  call void @llvm.lifetime.end.p0(i64 4, ptr nonnull %3) #18
  ret i32 %8

9:                                                ; preds = %5, %9
  %10 = phi i64 [ 0, %5 ], [ %16, %9 ]
  %11 = phi i32 [ 0, %5 ], [ %23, %9 ]
  %12 = getelementptr inbounds i8, ptr %0, i64 %10
  %13 = load i8, ptr %12, align 1, !tbaa !12
  %14 = and i64 %10, 3
  %15 = getelementptr inbounds [4 x i8], ptr %3, i64 0, i64 %14
  store i8 %13, ptr %15, align 1, !tbaa !12
  %16 = add nuw nsw i64 %10, 1
  %17 = and i64 %16, 3
  %18 = getelementptr inbounds [4 x i8], ptr %3, i64 0, i64 %17
  %19 = load i8, ptr %18, align 1, !tbaa !12
  %20 = zext i8 %19 to i32
  %21 = icmp ugt i64 %10, 3
  %22 = select i1 %21, i32 %20, i32 0
  %23 = add nuw nsw i32 %22, %11
  %24 = icmp eq i64 %16, %6
  br i1 %24, label %7, label %9, !llvm.loop !37
}

; Function Attrs: mustprogress nofree nosync nounwind willreturn memory(none) uwtable
define dso_local i32 @pun(float noundef %0) local_unnamed_addr #9 {
  %2 = alloca [2 x %union.anon], align 4
  call void @llvm.lifetime.start.p0(i64 8, ptr nonnull %2) #18
  store float %0, ptr %2, align 4, !tbaa !12
  %3 = bitcast float %0 to i32
  %4 = xor i32 %3, -2147483648
  %5 = getelementptr inbounds [2 x %union.anon], ptr %2, i64 0, i64 1
  store i32 %4, ptr %5, align 4, !tbaa !12
  %6 = fptosi float %0 to i32
  %7 = and i32 %6, 1
  %8 = zext i32 %7 to i64
  %9 = getelementptr inbounds [2 x %union.anon], ptr %2, i64 0, i64 %8
  %10 = getelementptr inbounds [4 x i8], ptr %9, i64 0, i64 3
  %11 = load i8, ptr %10, align 1, !tbaa !12
  %12 = zext i8 %11 to i32
  %13 = and i32 %6, 3
  %14 = zext i32 %13 to i64
  %15 = getelementptr inbounds [4 x i8], ptr %5, i64 0, i64 %14
  %16 = load i8, ptr %15, align 1, !tbaa !12
  %17 = zext i8 %16 to i32
  %18 = add nuw nsw i32 %17, %12
  call void @llvm.lifetime.end.p0(i64 8, ptr nonnull %2) #18
  ret i32 %18
}

; Function Attrs: mustprogress nofree norecurse nosync nounwind willreturn memory(readwrite, argmem: none, inaccessiblemem: none) uwtable
define dso_local i32 @keeps(i32 noundef %0) local_unnamed_addr #15 {
  %2 = load i32, ptr @count, align 4, !tbaa !5
  %3 = add nsw i32 %2, %0
  store i32 %3, ptr @count, align 4, !tbaa !5
  ret i32 %3
}

; Function Attrs: nofree norecurse nosync nounwind memory(none) uwtable
define dso_local i32 @sized(i32 noundef %0) local_unnamed_addr #16 {
  %2 = add i32 %0, 1
  %3 = zext i32 %2 to i64
  %4 = alloca i32, i64 %3, align 16
  %5 = icmp slt i32 %0, 0
  br i1 %5, label %9, label %6

6:                                                ; preds = %1
  %7 = add i32 %0, 1
  %8 = zext i32 %7 to i64
  br label %11

9:                                                ; preds = %11, %1
  %10 = icmp slt i32 %0, 0
  br i1 %10, label %18, label %20

11:                                               ; preds = %6, %11
  %12 = phi i64 [ 0, %6 ], [ %16, %11 ]
  %13 = trunc i64 %12 to i32
  %14 = mul nsw i32 %13, %13
  %15 = getelementptr inbounds i32, ptr %4, i64 %12
  store i32 %14, ptr %15, align 4, !tbaa !5
  %16 = add nuw nsw i64 %12, 1
  %17 = icmp eq i64 %16, %8
  br i1 %17, label %9, label %11, !llvm.loop !38

18:                                               ; preds = %20, %9
  %19 = phi i32 [ 0, %9 ], [ %28, %20 ]
  ret i32 %19

20:                                               ; preds = %9, %20
  %21 = phi i32 [ %29, %20 ], [ 0, %9 ]
  %22 = phi i32 [ %28, %20 ], [ 0, %9 ]
  %23 = mul nuw nsw i32 %21, 7
  %24 = srem i32 %23, %2
  %25 = zext i32 %24 to i64
  %26 = getelementptr inbounds i32, ptr %4, i64 %25
  %27 = load i32, ptr %26, align 4, !tbaa !5
  %28 = add nsw i32 %27, %22
  %29 = add nuw i32 %21, 1
  %30 = icmp eq i32 %21, %0
  br i1 %30, label %18, label %20, !llvm.loop !39
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local void @longs(ptr nocapture noundef %0, i32 noundef %1) local_unnamed_addr #17 {
  %3 = icmp sgt i32 %1, 0
  br i1 %3, label %4, label %6

4:                                                ; preds = %2
  %5 = zext i32 %1 to i64
  br label %7

6:                                                ; preds = %7, %2
  ret void

7:                                                ; preds = %4, %7
  %8 = phi i64 [ 0, %4 ], [ %12, %7 ]
  %9 = getelementptr inbounds i64, ptr %0, i64 %8
  %10 = load i64, ptr %9, align 8, !tbaa !15
  %11 = add nsw i64 %10, 1
  store i64 %11, ptr %9, align 8, !tbaa !15
  %12 = add nuw nsw i64 %8, 1
  %13 = icmp eq i64 %12, %5
  br i1 %13, label %6, label %7, !llvm.loop !40
}

attributes #0 = { nofree norecurse nosync nounwind memory(argmem: read) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #1 = { mustprogress nocallback nofree nosync nounwind willreturn memory(argmem: readwrite) }
attributes #2 = { mustprogress nofree norecurse nosync nounwind willreturn memory(none) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #3 = { nofree nosync nounwind memory(none) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #4 = { mustprogress nocallback nofree nounwind willreturn memory(argmem: readwrite) }
attributes #5 = { nounwind uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #6 = { mustprogress nofree nounwind willreturn memory(write) "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #7 = { nounwind "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #8 = { mustprogress nocallback nofree nosync nounwind speculatable willreturn memory(none) }
attributes #9 = { mustprogress nofree nosync nounwind willreturn memory(none) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #10 = { mustprogress nofree nosync nounwind willreturn memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #11 = { nofree norecurse nosync nounwind memory(read, inaccessiblemem: none) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #12 = { nofree norecurse nosync nounwind memory(write, argmem: readwrite, inaccessiblemem: none) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #13 = { mustprogress nofree norecurse nosync nounwind willreturn memory(argmem: read) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #14 = { nofree nosync nounwind memory(argmem: read) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #15 = { mustprogress nofree norecurse nosync nounwind willreturn memory(readwrite, argmem: none, inaccessiblemem: none) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #16 = { nofree norecurse nosync nounwind memory(none) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #17 = { nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #18 = { nounwind }

!llvm.module.flags = !{!0, !1, !2, !3}
!llvm.ident = !{!4}

!0 = !{i32 1, !"wchar_size", i32 4}
!1 = !{i32 8, !"PIC Level", i32 2}
!2 = !{i32 7, !"PIE Level", i32 2}
!3 = !{i32 7, !"uwtable", i32 2}
!4 = !{!"Debian clang version 16.0.6 (15~deb12u1)"}
!5 = !{!6, !6, i64 0}
!6 = !{!"int", !7, i64 0}
!7 = !{!"omnipotent char", !8, i64 0}
!8 = !{!"Simple C/C++ TBAA"}
!9 = distinct !{!9, !10, !11}
!10 = !{!"llvm.loop.mustprogress"}
!11 = !{!"llvm.loop.unroll.disable"}
!12 = !{!7, !7, i64 0}
!13 = !{!14, !14, i64 0}
!14 = !{!"short", !7, i64 0}
!15 = !{!16, !16, i64 0}
!16 = !{!"long", !7, i64 0}
!17 = !{!18, !18, i64 0}
!18 = !{!"float", !7, i64 0}
!19 = distinct !{!19, !10, !11}
!20 = distinct !{!20, !10, !11}
!21 = distinct !{!21, !10, !11}
!22 = distinct !{!22, !10, !11}
!23 = !{!24, !7, i64 0}
!24 = !{!"P", !7, i64 0, !14, i64 2, !6, i64 4}
!25 = !{!24, !14, i64 2}
!26 = !{!24, !6, i64 4}
!27 = distinct !{!27, !10, !11}
!28 = !{i64 0, i64 1, !12, i64 2, i64 2, !13, i64 4, i64 4, !5}
!29 = !{i64 0, i64 2, !13, i64 2, i64 4, !5}
!30 = !{i64 0, i64 4, !5}
!31 = distinct !{!31, !10, !11}
!32 = !{i64 0, i64 65}
!33 = !{i32 0, i32 32}
!34 = distinct !{!34, !10, !11}
!35 = distinct !{!35, !10, !11}
!36 = distinct !{!36, !10, !11}
!37 = distinct !{!37, !10, !11}
!38 = distinct !{!38, !10, !11}
!39 = distinct !{!39, !10, !11}
!40 = distinct !{!40, !10, !11}
